"""Solve what is missing of a study, cheapest first, and store every load as soon as it is finished.
Collective."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from hpc_gfmd import __version__
from hpc_gfmd.contact import area, distributions_named, gap, observables_named
from hpc_gfmd.driver.warmup import compile_once
from hpc_gfmd.parallel.guard import on_rank_0
from hpc_gfmd.parallel.interrupt import Interrupt, Stopped
from hpc_gfmd.parallel.world import threads_of
from hpc_gfmd.runs.composition import sweep_of
from hpc_gfmd.runs.memory import require_memory
from hpc_gfmd.runs.timing import expected_seconds
from hpc_gfmd.scene import Solver
from hpc_gfmd.surface import build_surface
from hpc_gfmd.util.errors import GfmdError, SceneError

from .case import DISTRIBUTION, Case
from .store import Store, key_of, missing

PER_LOAD = 0.02  # seconds that a load takes at least
FIELDS = (
    "hurst",
    "L_over_lam_l",
    "lam_l_over_lam_s",
    "lam_s_over_a",
    "n",
    "seed",
    "accuracy",
    "eps_t",
    "eps_f",
    "eps_c",
)
SWEEP = ("p_star", "observables", "distributions")


@dataclass(frozen=True)
class Outcome:
    """solved: number of loads; failed: one line per case that could not be solved; unconverged:
    number of loads that did not reach their accuracy; exit_code: 0, 1 (failed), 3 (unconverged),
    130 or 143 (stopped by a signal)."""

    solved: int
    failed: tuple[str, ...]
    unconverged: int
    exit_code: int


class NotStored(GfmdError):
    """A solved load could not be written: it makes no sense to go on."""


def merged(cases: list[Case]) -> list[Case]:
    """Cases that share a surface as one sweep over all their loads, cheapest first."""
    loads: dict[tuple, tuple] = {}
    for case in cases:
        for kept, more in zip(
            loads.setdefault(case.surface, (case, set(), set(), set()))[1:],
            (case.p_star, case.observables, case.distributions),
            strict=True,
        ):
            kept.update(more)
    whole = (
        replace(case, **{name: tuple(sorted(kept)) for name, kept in zip(SWEEP, more, strict=True)})
        for case, *more in loads.values()
    )
    return sorted(whole, key=lambda case: (case.cost, case.surface))


def share(cases: list[Case], part: int, parts: int) -> list[Case]:
    """The part-th (from 1) of `parts` shares of about equal cost. It depends on nothing but the
    cases: shares of jobs that start at different times are disjoint and together complete."""
    load, mine = [0] * parts, []
    for case in reversed(merged(cases)):
        least = load.index(min(load))
        load[least] += case.cost
        if least == part - 1:
            mine.append(case)
    return mine


def seconds_of(case: Case, ranks: int = 1) -> float:
    """Expected seconds of a case on this machine; 0 for one that cannot be solved."""
    try:
        return expected_seconds(case.scene(), (case.n, case.n), ranks, ranks) + PER_LOAD * len(
            case.p_star
        )
    except SceneError:
        return 0.0


def run_missing(
    cases: list[Case],
    store: Store,
    comm: Any,
    threads: int | str = 1,
    say: Callable[[str], object] = print,
    dry: bool = False,
) -> Outcome:
    """Solve the loads of these cases that are not stored; returns an Outcome. Collective.

    say(text) prints on rank 0. A case that cannot be solved is reported and left out. A signal ends
    the run; what is finished stays stored. Raises GfmdError where the folder cannot be read or
    written. dry: say what would be solved, and stop.
    """
    stored = on_rank_0(
        comm, f"reading {store.folder}", lambda: {key_of(run): set(run) for run in store.load()}
    )
    todo = merged([left for case in cases if (left := missing(case, stored))])
    speak = say if comm.rank == 0 else lambda text: None
    seconds = on_rank_0(
        comm, "estimating the time", lambda: [seconds_of(case, comm.size) for case in todo]
    )
    speak(_plan(cases, todo, seconds))
    if dry or not todo:
        return Outcome(0, (), 0, 0)
    on_rank_0(
        comm, f"making {store.folder}", lambda: store.folder.mkdir(parents=True, exist_ok=True)
    )
    each, solved, unconverged, failed = threads_of(comm, threads), 0, 0, []
    begun = time.monotonic()
    with Interrupt(comm) as interrupt:
        compile_once(comm, Solver(accuracy=todo[0].accuracy))
        for index, case in enumerate(todo):
            started = time.monotonic()
            statuses, error = _attempt(case, store, comm, each, interrupt)
            solved += len(statuses)
            unconverged += sum(status != "converged" for status in statuses)
            if error:
                failed.append(f"{case}: {error}")
                speak(f"FAILED  {failed[-1]}")
            if interrupt.agreed or interrupt.poll()[0]:
                speak(
                    f"stopped after {solved} loads; what is finished is kept: the same command"
                    " continues"
                )
                return Outcome(solved, tuple(failed), unconverged, interrupt.exit_code)
            if not error:
                now = time.monotonic()
                speak(
                    f"{index + 1}/{len(todo)}  {case}: {len(statuses)} loads in {now - started:.2f}"
                    f" s; {now - begun:.0f} s so far, about {sum(seconds[index + 1 :]):.0f} s to go"
                )
    return Outcome(solved, tuple(failed), unconverged, 1 if failed else 3 if unconverged else 0)


def _plan(cases: list[Case], todo: list[Case], seconds: list[float]) -> str:
    whole, left = sum(len(c.p_star) for c in merged(cases)), sum(len(c.p_star) for c in todo)
    text = f"{whole} loads, {whole - left} of them stored"
    return (
        f"{text}; to solve: {left} on {len(todo)} surfaces, about {sum(seconds) / 60:.1f} minutes"
        if todo
        else text
    )


def _attempt(
    case: Case, store: Store, comm: Any, threads: int, interrupt: Any
) -> tuple[list[str], str | None]:
    """(status of every finished load, what went wrong or None). Only errors that all ranks see can
    be survived on several ranks."""
    statuses: list[str] = []
    try:
        scene: Any = case.scene()
        require_memory(comm, scene, scene.n, scene.surface.physical_sizes, threads)
        sweep = sweep_of(
            scene,
            lambda dtype: build_surface(
                scene.surface, comm, dtype, threads, scene.solver.low_memory
            ),
        )
        for p_star, p in zip(case.p_star, sweep.pressures(scene.load), strict=True):
            begun = time.monotonic()
            step = sweep.solve(p, lambda *_: interrupt.poll()[0])
            if step.contact.outcome.status == "interrupted":
                break
            run = _run(case, p_star, step, time.monotonic() - begun, comm.size)
            _keep(run, store, comm)
            statuses.append(run["status"])
            if interrupt.poll()[0]:
                break
    except NotStored:
        raise
    except Stopped:  # the Interrupt knows
        pass
    except GfmdError as error:
        return statuses, str(error)
    except Exception as error:
        if comm.size > 1:
            raise
        return statuses, f"{type(error).__name__}: {error}"
    return statuses, None


def _keep(run: dict, store: Store, comm: Any) -> None:
    try:
        on_rank_0(comm, str(store.path), lambda: store.append(run))
    except GfmdError as error:
        raise NotStored(str(error)) from None


def _run(case: Case, p_star: float, step: Any, seconds: float, ranks: int) -> dict:
    """What is kept of a load: dimensionless numbers, lengths in units of the cell."""
    contact, a_r = step.contact, area.a_r(step.contact)
    a_r_edge: Any = area.a_r_corrected(contact)  # known of a self-affine surface
    a_r_error, gap_error, pressure_error = contact.outcome.errors
    more: dict[str, Any] = {
        name: of_contact(contact)
        for name, of_contact in observables_named(case.observables).items()
    }
    found = distributions_named(case.distributions, contact)
    more |= {
        DISTRIBUTION.format(name): (
            found.get(name) and {what: values.tolist() for what, values in found[name].items()}
        )
        for name in case.distributions
    }
    run = {
        **{name: getattr(case, name) for name in FIELDS},
        "p_star": p_star,
        "h_rms": contact.h_rms,
        "g_rms": contact.g_rms,
        "lam_s": contact.lam_s,
        "a_r": a_r,
        "a_r_edge": a_r_edge,
        "kappa": a_r / p_star,
        "kappa_edge": a_r_edge / p_star,
        "gap_over_h_rms": gap.gap_over_h_rms(contact),
        "gap_over_g_rms_lam_s": gap.gap_over_g_rms_lam_s(contact),
        "contact_points": int(contact.contact_points),
        "a_r_error": float(a_r_error),
        "gap_error": float(gap_error),
        "pressure_error": float(pressure_error),
        "status": contact.outcome.status,
        "iterations": int(step.iterations),
        "fft_pairs": float(step.fft_pairs),
        "wall_seconds": seconds,
        "precision": contact.g.dtype.name,
        "ranks": ranks,
        "version": __version__,
    } | more
    return {
        k: None if isinstance(v, float) and not isfinite(v) else v for k, v in run.items()
    }  # JSON has no inf and no nan
