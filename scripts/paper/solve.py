"""Solve the missing loads, cheapest first, and store each sweep once it is finished. Collective."""

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
OBSERVABLES = ("a_r", "a_r_corrected", "gap_over_h_rms", "gap_over_g_rms_lam_s")
COLUMNS = (  # of a load in the result file
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
) -> int:
    """Solve the loads of these cases that are not stored. Collective.

    A case that cannot be solved is reported and skipped. A signal ends the run: finished loads are
    kept, and the same command resumes the interrupted sweep. say(line) is called on rank 0 only.
    Return the exit code: 0, 1 (a case failed), 3 (a load did not reach its accuracy), 130 or 143 (a
    signal). Raises GfmdError if the folder cannot be read or written.
    """
    report = say if comm.rank == 0 else lambda text: None
    unsolved, plan = on_rank_0(comm, f"reading {store.folder}", lambda: _plan(cases, store))
    report(plan)
    if not unsolved:
        return 0
    folder = store.folder / "solving"
    on_rank_0(comm, f"making {folder}", lambda: folder.mkdir(parents=True, exist_ok=True))
    begin = time.monotonic()
    cost_done = 0
    exit_code = 0
    for index, case in enumerate(unsolved):
        try:
            code = _solve(case, store, folder, comm, threads)
        except GfmdError as error:
            if store.path.name in str(error):
                raise
            exit_code = 1
            report(f"FAILED  {case}: {error}")
            continue
        if code > 3:
            report("stopped: finished loads are kept, the same command resumes")
            return code
        exit_code = exit_code or code
        cost_done += case.cost
        elapsed = time.monotonic() - begin
        cost_left = sum(case.cost for case in unsolved[index + 1 :])
        report(
            f"{index + 1}/{len(unsolved)}  {case}; {elapsed:.0f} s so far, about"
            f" {elapsed / cost_done * cost_left:.0f} s to go"
        )
    with suppress(OSError):  # another rank was first
        folder.rmdir()
    return exit_code


def _solve(case, store, folder, comm, threads):
    """Solve a case, store its loads and return the exit code of the run."""
    text = _scene(case, threads)
    scene = folder / f"{crc32(text.encode()):08x}.toml"
    out = scene.with_suffix(".h5")
    on_rank_0(comm, f"writing {scene}", lambda: scene.write_text(text))
    result = hpc_gfmd.run(scene, out=out, quiet=True, comm=comm)
    if result.exit_code <= 3:

        def store_runs():
            store.append(_runs_of(case, out, comm.size))
            scene.unlink()
            out.unlink()

        on_rank_0(comm, str(store.path), store_runs)
    return result.exit_code


def _plan(cases, store):
    """Return the sweeps that are not stored, and a line about them.

    The time that they need is estimated from the stored runs.
    """
    unsolved = store.missing(cases)
    runs = store.stored().values()
    n_loads = sum(len(case.p_star) for case in merged(cases))
    n_unsolved = sum(len(case.p_star) for case in unsolved)
    text = f"{n_loads} loads, {n_loads - n_unsolved} of them stored"
    if unsolved:
        largest = max(case.n for case in unsolved)
        text += f"; to solve: {n_unsolved} on {len(unsolved)} surfaces, up to n = {largest}"
        minutes = sum(run["wall_seconds"] for run in runs) / 60
        points = sum(run["n"] ** 2 for run in runs)
        if points:
            text += f", about {minutes / points * sum(case.cost for case in unsolved):.1f} minutes"
    return unsolved, text


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
                "observables": [*OBSERVABLES, *case.observables],
                "distributions": list(case.distributions),
            },
            "machine": {"threads": threads},
        }
    )


def _runs_of(case, path, ranks):
    """Return the runs of a result file: dimensionless numbers, lengths in units of the cell."""
    runs: Rows = []
    for solution, p_star in zip(hpc_gfmd.load(path), case.p_star, strict=True):
        step = solution.result.steps[0]
        run = case.surface | {"n": case.n} | case.eps
        run |= {name: step[name] for name in COLUMNS} | {"p_star": p_star}
        run |= {"h_rms": solution.h_rms, "g_rms": solution.g_rms, "ranks": ranks}
        run |= {"lam_s": 1 / (case.L_over_lam_l * case.lam_l_over_lam_s)}
        run |= {"a_r_edge": step["a_r_corrected"], "kappa": step["a_r"] / p_star}
        run |= {"kappa_edge": step["a_r_corrected"] / p_star, "version": hpc_gfmd.__version__}
        run |= {name: step.get(name) for name in case.observables}
        for name in case.distributions:
            histogram = solution.distributions.get(name)
            run[f"{name}_distribution"] = histogram and {
                key: values.tolist() for key, values in histogram.items()
            }
        runs.append(run)
    return runs
