"""Solve what is missing, cheapest first, and store it as soon as it is finished. Collective."""

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any
from zlib import crc32

import tomli_w

import hpc_gfmd
from hpc_gfmd import GfmdError, on_rank_0

from .cases import Case, Store, merged
from .rows import Rows

LARGE = 2**15  # points along an axis from which a surface is solved in low memory
ALWAYS = ("a_r", "a_r_corrected", "gap_over_h_rms", "gap_over_g_rms_lam_s")
KEPT = (
    *("p_star", "a_r", "gap_over_h_rms", "gap_over_g_rms_lam_s"),
    *("a_r_error", "gap_error", "pressure_error", "status", "iterations", "fft_pairs"),
    *("wall_seconds", "precision"),
)


def run_missing(
    cases: list[Case],
    store: Store,
    comm: Any,
    threads: int | str = 1,
    say: Callable[[str], object] = print,
    dry: bool = False,
) -> int:
    """Solve the loads of these cases that are not stored; dry: only say what would be solved.

    say(text) prints on rank 0. A case that cannot be solved is reported and left out. A signal ends
    the run; what is finished is kept, and the sweep that was interrupted is continued by the same
    command. Returns the exit code: 0, 1 (a case failed), 3 (a load did not reach its accuracy), 130
    or 143. Raises GfmdError where the folder cannot be read or written.
    """
    speak = say if comm.rank == 0 else lambda text: None
    todo, plan = on_rank_0(comm, f"reading {store.folder}", lambda: _plan(cases, store))
    speak(plan)
    if dry or not todo:
        return 0
    folder = store.folder / "solving"
    on_rank_0(comm, f"making {folder}", lambda: folder.mkdir(parents=True, exist_ok=True))
    begun, done, worst = time.monotonic(), 0, 0
    for index, case in enumerate(todo):
        try:
            code = _solve(case, store, folder, comm, threads)
        except GfmdError as error:
            if store.path.name in str(error):
                raise
            worst = 1
            speak(f"FAILED  {case}: {error}")
            continue
        if code > 3:
            speak("stopped; what is finished is kept: the same command continues")
            return code
        worst = worst or code
        done += case.cost
        passed = time.monotonic() - begun
        left = passed / done * sum(case.cost for case in todo[index + 1 :])
        speak(f"{index + 1}/{len(todo)}  {case}; {passed:.0f} s so far, about {left:.0f} s to go")
    with suppress(OSError):  # another rank was first, or another job still solves
        folder.rmdir()
    return worst


def _solve(case, store, folder, comm, threads):
    """Solve a case and store its loads; returns the exit code of the run."""
    text = _scene(case, threads)
    scene = folder / f"{crc32(text.encode()):08x}.toml"
    out = scene.with_suffix(".h5")
    on_rank_0(comm, f"writing {scene}", lambda: scene.write_text(text))
    result = hpc_gfmd.run(scene, out=out, quiet=True, comm=comm)
    if result.exit_code <= 3:

        def keep():
            store.append(_runs_of(case, out, comm.size))
            scene.unlink()
            out.unlink()

        on_rank_0(comm, str(store.path), keep)
    return result.exit_code


def _plan(cases, store):
    """Say what is left to solve; how long it takes follows from what is stored."""
    todo, runs = store.missing(cases), store.stored().values()
    whole, left = (sum(len(case.p_star) for case in part) for part in (merged(cases), todo))
    text = f"{whole} loads, {whole - left} of them stored"
    if todo:
        text += f"; to solve: {left} on {len(todo)} surfaces, up to n = {max(c.n for c in todo)}"
        seconds = sum(run["wall_seconds"] for run in runs) / 60
        points = sum(run["n"] ** 2 for run in runs)
        if points:
            text += f", about {seconds / points * sum(case.cost for case in todo):.1f} minutes"
    return todo, text


def _scene(case, threads):
    surface = case.surface | {"kind": "self-affine"}
    solver = {"accuracy": surface.pop("accuracy"), "low_memory": case.n >= LARGE}
    return tomli_w.dumps(
        {
            "surface": surface,
            "load": {"p_star": list(case.p_star)},
            "solver": solver,
            "output": {
                "fields": [],
                "observables": [*ALWAYS, *case.observables],
                "distributions": list(case.distributions),
            },
            "machine": {"threads": threads},
        }
    )


def _runs_of(case, path, ranks):
    """Read the loads of a result file: dimensionless numbers, lengths in units of the cell."""
    runs: Rows = []
    for solution, p_star in zip(hpc_gfmd.load(path), case.p_star, strict=True):
        step = solution.result.steps[0]
        run = case.surface | {"n": case.n} | case.eps
        run |= {name: step[name] for name in KEPT} | {"p_star": p_star}
        run |= {"h_rms": solution.h_rms, "g_rms": solution.g_rms, "ranks": ranks}
        run |= {"lam_s": 1 / (case.L_over_lam_l * case.lam_l_over_lam_s)}
        run |= {"a_r_edge": step["a_r_corrected"], "kappa": step["a_r"] / p_star}
        run |= {"kappa_edge": step["a_r_corrected"] / p_star, "version": hpc_gfmd.__version__}
        run |= {name: step.get(name) for name in case.observables}
        for name in case.distributions:
            found = solution.distributions.get(name)
            run[f"{name}_distribution"] = found and {k: v.tolist() for k, v in found.items()}
        runs.append(run)
    return runs
