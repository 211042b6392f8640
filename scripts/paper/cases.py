"""The surfaces and loads to solve, in series at three levels of effort, and the store of those that
are solved."""

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
DIGITS = 9  # significant digits by which the numbers of two runs are compared


@dataclass(frozen=True)
class Case:
    """A self-affine surface in a cell of side 1 with g_rms = 1 and E_star = 1, and its loads.

    Cases that differ in lam_s_over_a alone are the same surface on different grids.

    Attributes
    ----------
    hurst : float
        Hurst exponent H.
    L_over_lam_l, lam_l_over_lam_s, lam_s_over_a : float
        Ratios of the paper: 1/eps_t, 1/eps_f and 1/eps_c.
    seed : int
        Seed of the realisation.
    p_star : tuple of float
        Loads p/(E* g_rms).
    accuracy : float
        Requested of the solver.
    observables, distributions : tuple of str
        Results of every load beyond those of all cases, by their names in a scene.
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
        """Points along an axis."""
        return round(self.L_over_lam_l * self.lam_l_over_lam_s * self.lam_s_over_a)

    @property
    def eps(self) -> dict[str, float]:
        """The inverse ratios: {"eps_t": ..., "eps_f": ..., "eps_c": ...}."""
        ratios = (self.L_over_lam_l, self.lam_l_over_lam_s, self.lam_s_over_a)
        return {f"eps_{i}": 1 / ratio for i, ratio in zip("tfc", ratios)}

    @property
    def surface(self) -> dict[str, Any]:
        """The columns that cases share if they can be solved in one sweep."""
        return {name: getattr(self, name) for name in SURFACE}

    @property
    def cost(self) -> int:
        """Grid points times loads."""
        return self.n**2 * len(self.p_star)

    @property
    def keys(self) -> list[tuple[float, ...]]:
        """The keys of its loads, as `key_of` makes them for stored runs."""
        return [key_of(self.surface | {"p_star": p}) for p in self.p_star]

    def is_in(self, stored: dict[tuple, dict], key: tuple) -> bool:
        """Return whether the load of a key (one of `keys`) is stored, as `Store.stored` returns it,
        with all its observables and distributions."""
        columns = {*self.observables, *(f"{name}_distribution" for name in self.distributions)}
        return key in stored and columns <= set(stored[key])

    def __str__(self):
        return (
            f"H = {self.hurst:g}, L/lam_l = {self.L_over_lam_l:g}, lam_l/lam_s ="
            f" {self.lam_l_over_lam_s:g}, lam_s/a = {self.lam_s_over_a:g} (n = {self.n}), seed"
            f" {self.seed}"
        )


def key_of(run: dict) -> tuple[float, ...]:
    """Return what identifies a stored run: its surface, accuracy and load."""
    return tuple(float(f"{run[name]:.{DIGITS}g}") for name in (*SURFACE, "p_star"))


def series(name: str, level: str, hurst: Iterable[float] | None = None) -> list[Case]:
    """Return the cases of a series of the catalogue at a level, for its own Hurst exponents or
    others. Raises SceneError if there is no such level."""
    if level not in LEVELS:
        raise SceneError(f"--level: found {level!r}, allowed: {', '.join(LEVELS)}")
    entry = CATALOGUE["series"][name]
    results: Any = {key: tuple(entry.get(key, ())) for key in ("observables", "distributions")}
    default_loads = level if level in entry["loads"] else "all"
    cases = []
    for L, F, C, seeds, *exceptions in entry[level]:
        for H in hurst or entry["hurst"]:
            if exceptions and H not in exceptions[0]:
                continue
            loads_name = exceptions[1] if len(exceptions) > 1 else default_loads
            loads = tuple(entry["loads"][loads_name])
            cases += [Case(H, L, F, C, seed, loads, **results) for seed in range(1, seeds + 1)]
    return cases


def cases_of(item: str, level: str) -> list[Case]:
    """Return the cases that a figure or table needs at a level."""
    entry = CATALOGUE["items"][item]
    return [case for name in entry["series"] for case in series(name, level, entry.get("hurst"))]


def merged(cases: list[Case]) -> list[Case]:
    """Return the cases with one sweep over all loads for each surface, cheapest first."""
    by_surface = defaultdict(list)
    for case in cases:
        by_surface[*case.surface.values()].append(case)
    sweeps = []
    for same_surface in by_surface.values():
        union: Any = {
            name: tuple(sorted({x for case in same_surface for x in getattr(case, name)}))
            for name in ("p_star", "observables", "distributions")
        }
        sweeps.append(replace(same_surface[0], **union))
    return sorted(sweeps, key=lambda case: (case.cost, *case.surface.values()))


class Store:
    """The runs in a folder: one JSON line per surface and load in files runs*.jsonl or .jsonl.gz.

    Lines are appended to `path` when a load is solved and never change.
    """

    def __init__(self, folder):
        self.folder = Path(folder)
        self.path = self.folder / "runs.jsonl"

    def stored(self) -> dict[tuple, dict]:
        """Return {key: run} of all files.

        A run that was stored twice has the columns of both lines. Lines that are incomplete or no
        runs are skipped.
        """
        runs: dict[tuple, dict] = {}
        for path in sorted(self.folder.glob("runs*.jsonl*")):
            content = path.read_bytes()
            content = gzip.decompress(content) if path.suffix == ".gz" else content
            for line in content.split(b"\n"):
                try:
                    run = json.loads(line)
                    runs[key_of(run)] = runs.get(key_of(run), {}) | run
                except (ValueError, TypeError, KeyError):
                    continue
        return runs

    def runs_of(self, cases: list[Case]) -> Rows:
        """Return the stored runs of these cases that have all their results, each once."""
        stored = self.stored()
        keys = (key for case in cases for key in case.keys if case.is_in(stored, key))
        return [stored[key] for key in dict.fromkeys(keys)]

    def missing(self, cases: list[Case]) -> list[Case]:
        """Return the sweeps that are not stored yet, cheapest first."""
        stored = self.stored()
        unsolved = []
        for case in cases:
            loads = zip(case.p_star, case.keys)
            missing_loads = tuple(p for p, key in loads if not case.is_in(stored, key))
            if missing_loads:
                unsolved.append(replace(case, p_star=missing_loads))
        return merged(unsolved)

    def append(self, runs: Rows) -> None:
        """Append runs and sync them to the disk. Raises OSError."""
        text = "".join(json.dumps(run, allow_nan=False) + "\n" for run in runs).encode()
        with open(self.path, "ab+") as file:
            file.seek(max(0, file.tell() - 1))
            is_torn = file.read() not in (b"", b"\n")  # the last line is incomplete
            file.write(b"\n" + text if is_torn else text)
            file.flush()
            os.fsync(file.fileno())
