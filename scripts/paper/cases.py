"""What is solved: surfaces and their loads, in series at three levels of effort, and the store of
what is there."""

import gzip
import json
import os
import tomllib
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from hpc_gfmd import SceneError

from .rows import Rows

CATALOGUE = tomllib.loads(Path(__file__).with_name("catalogue.toml").read_text(encoding="utf-8"))
LEVELS = ("quick", "desk", "paper")
SURFACE = ("hurst", "L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a", "seed", "accuracy")
DIGITS = 9  # of a number that tells runs apart


@dataclass(frozen=True)
class Case:
    """A self-affine surface in the cell of side 1 with g_rms = 1 and E_star = 1, and a sweep over
    p_star.

    The ratios are those of the paper: L/lam_l = 1/eps_t, lam_l/lam_s = 1/eps_f, lam_s/a = 1/eps_c.
    Cases that differ in lam_s_over_a alone are the same surface on another grid. observables,
    distributions: what is wanted of every load beyond what all have, by the names of a scene.
    """

    hurst: float
    L_over_lam_l: float
    lam_l_over_lam_s: float
    lam_s_over_a: float
    seed: int
    p_star: tuple[float, ...]
    accuracy: float = 1e-3
    observables: tuple[str, ...] = ()
    distributions: tuple[str, ...] = ()

    @property
    def n(self) -> int:
        """Count the points along an axis."""
        return round(self.L_over_lam_l * self.lam_l_over_lam_s * self.lam_s_over_a)

    @property
    def eps(self) -> dict[str, float]:
        """Invert the ratios: {"eps_t": ..., "eps_f": ..., "eps_c": ...}."""
        ratios = (self.L_over_lam_l, self.lam_l_over_lam_s, self.lam_s_over_a)
        return {f"eps_{i}": 1 / ratio for i, ratio in zip("tfc", ratios)}

    @property
    def surface(self) -> dict[str, Any]:
        """Tell what cases share that can be one sweep."""
        return {name: getattr(self, name) for name in SURFACE}

    @property
    def cost(self) -> int:
        """Count grid points times loads."""
        return self.n**2 * len(self.p_star)

    @property
    def keys(self) -> list[tuple[float, ...]]:
        """Tell the loads from others, as key_of does for what is stored."""
        return [key_of(self.surface | {"p_star": p}) for p in self.p_star]

    def is_in(self, stored: dict[tuple, dict], key: tuple) -> bool:
        """Tell whether a load is stored with all that is wanted of it."""
        wanted = {*self.observables, *(f"{name}_distribution" for name in self.distributions)}
        return key in stored and wanted <= set(stored[key])

    def __str__(self):
        return (
            f"H = {self.hurst:g}, L/lam_l = {self.L_over_lam_l:g}, lam_l/lam_s ="
            f" {self.lam_l_over_lam_s:g}, lam_s/a = {self.lam_s_over_a:g} (n = {self.n}), seed"
            f" {self.seed}"
        )


def key_of(run: dict) -> tuple[float, ...]:
    """Tell a stored run from others: by the surface, the accuracy and the load."""
    return tuple(float(f"{run[name]:.{DIGITS}g}") for name in (*SURFACE, "p_star"))


def series(name: str, level: str, hurst: Iterable[float] | None = None) -> list[Case]:
    """List the cases of a series of the catalogue, of some H or of all. Raises SceneError."""
    if level not in LEVELS:
        raise SceneError(f"--level: found {level!r}, allowed: {', '.join(LEVELS)}")
    one, cases = CATALOGUE["series"][name], []
    wanted: Any = {what: tuple(one.get(what, ())) for what in ("observables", "distributions")}
    usual = level if level in one["loads"] else "all"
    for L, F, C, seeds, *only in one[level]:
        for H in hurst or one["hurst"]:
            if only and H not in only[0]:
                continue
            loads = tuple(one["loads"][only[1] if len(only) > 1 else usual])
            cases += [Case(H, L, F, C, seed, loads, **wanted) for seed in range(1, seeds + 1)]
    return cases


def cases_of(item: str, level: str) -> list[Case]:
    """List the cases of a figure or table."""
    one = CATALOGUE["items"][item]
    return [case for name in one["series"] for case in series(name, level, one.get("hurst"))]


def merged(cases: list[Case]) -> list[Case]:
    """Join cases that share a surface to one sweep over all their loads, cheapest first."""
    alike, whole = defaultdict(list), []
    for case in cases:
        alike[*case.surface.values()].append(case)
    for part in alike.values():
        union: Any = {
            name: tuple(sorted({x for case in part for x in getattr(case, name)}))
            for name in ("p_star", "observables", "distributions")
        }
        whole.append(replace(part[0], **union))
    return sorted(whole, key=lambda case: (case.cost, *case.surface.values()))


def share(cases: list[Case], part: int, parts: int) -> list[Case]:
    """Choose the part-th (from 1) of `parts` shares of about equal cost.

    It depends on nothing but the cases: shares of jobs that start at different times are disjoint
    and together complete.
    """
    load, mine = [0] * parts, []
    for case in reversed(merged(cases)):
        least = load.index(min(load))
        load[least] += case.cost
        if least == part - 1:
            mine.append(case)
    return mine


class Store:
    """The lines of all runs*.jsonl in a folder, packed (.gz) or not: one JSON line per surface
    and load, appended when it is finished and never changed.

    part: write runs-<part>.jsonl, so that several jobs can share the folder.
    """

    def __init__(self, folder, part=None):
        self.folder = Path(folder)
        self.path = self.folder / ("runs.jsonl" if part is None else f"runs-{part}.jsonl")

    def stored(self) -> dict[tuple, dict]:
        """Read {key: run}, one that was stored twice once, with the columns of both.

        A line that is torn, or no run, is left out.
        """
        found: dict[tuple, dict] = {}
        for path in sorted(self.folder.glob("runs*.jsonl*")):
            content = path.read_bytes()
            content = gzip.decompress(content) if path.suffix == ".gz" else content
            for line in content.split(b"\n"):
                try:
                    run = json.loads(line)
                    found[key_of(run)] = found.get(key_of(run), {}) | run
                except (ValueError, TypeError, KeyError):
                    continue
        return found

    def runs_of(self, cases: list[Case]) -> Rows:
        """Read the runs that these cases ask for, with all that they ask for."""
        stored = self.stored()
        keys = (key for case in cases for key in case.keys if case.is_in(stored, key))
        return [stored[key] for key in dict.fromkeys(keys)]

    def missing(self, cases: list[Case]) -> list[Case]:
        """List the sweeps that are left to solve, cheapest first."""
        stored, todo = self.stored(), []
        for case in cases:
            loads = zip(case.p_star, case.keys)
            left = tuple(p for p, key in loads if not case.is_in(stored, key))
            todo += [replace(case, p_star=left)] if left else []
        return merged(todo)

    def append(self, runs: Rows) -> None:
        """Add runs, which are on the disk when this returns. Raises OSError."""
        text = "".join(json.dumps(run, allow_nan=False) + "\n" for run in runs).encode()
        with open(self.path, "ab+") as file:
            file.seek(max(0, file.tell() - 1))
            torn = file.read() not in (b"", b"\n")  # a torn line stays alone
            file.write(b"\n" + text if torn else text)
            file.flush()
            os.fsync(file.fileno())
