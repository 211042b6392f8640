"""Solve walls of the campaign as a user would, and compare true with claimed errors."""

import signal
import tempfile
import time
import warnings
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import tomli_w

import hpc_gfmd

from .families import make
from .truth import truths

ERROR_OF_TARGET = {"a_r": 0, "gap_over_h_rms": 1}  # index of the error of a target
EQUAL_LOADS = 1e-12  # relative difference of loads that count as equal
ROUNDED_TARGET = 1e-9  # relative rounding errors of a target
# Time limit for all truths of a wall, and for all its loads in one way.
SECONDS = 120


class TooSlow(Exception):
    """A solve took longer than SECONDS."""


STATUS_OF_ERROR = {"TooSlow": "too slow", "SceneError": "refused"}


def rows_of(name, seed, index, ways, seconds=SECONDS):
    """Solve a wall in several ways.

    Parameters
    ----------
    name, seed, index
        Family, seed and number of the wall.
    ways : list of tuple
        (solver, precision, accuracy, low_memory).
    seconds : float
        Time limit.

    Returns
    -------
    list of dict
        A row for each way and load; errors are rows, too.
    """
    head = {"family": name, "seed": seed, "index": index}
    try:
        wall = make(name, seed, index)
        if wall.judge is not None:
            head["n"] = list(wall.heights.shape)
            return _rows_of_judge(wall, head, ways, seconds)
        with _time_limit(seconds):
            contact, exact, hardness = truths(
                wall.heights,
                wall.physical_sizes,
                wall.loads,
                wall.free,
                wall.hardness,
                wall.hardness_star,
            )
    except Exception as error:  # the campaign continues
        return [head | {"status": "no wall", "error": f"{type(error).__name__}: {error}"}]
    head["n"] = list(wall.heights.shape)
    if wall.targets is not None:
        return rows_of_targets(head, wall, contact, ways, seconds, hardness)
    rows = []
    if hardness is not None:
        hardness *= wall.E_star * contact.g_rms
    for solver, precision, accuracy, low_memory in ways:
        if (low_memory and wall.surface is None) or (solver != "bpx" and (low_memory or hardness)):
            continue
        way = {"solver": solver, "precision": precision, "accuracy": accuracy}
        way = head | way | {"low_memory": low_memory}
        begin = time.perf_counter()
        loads = iter(enumerate(wall.loads))
        try:
            with _time_limit(seconds), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                for solution, truth in zip(_solutions(wall, contact, way, hardness), exact):
                    load, p_star = next(loads)
                    judged = _judged(solution, truth, contact, wall)
                    rows.append(way | {"load": load, "p_star": p_star} | judged)
        except Exception as error:
            load, p_star = next(loads, (0, wall.loads[0]))
            rows.append(way | {"load": load, "p_star": p_star} | _failed(error))
        rows[-1]["seconds"] = round(time.perf_counter() - begin, 4)
    return rows


def _failed(error):
    """Return the columns of a load that raised an error."""
    kind = type(error).__name__
    return {"status": STATUS_OF_ERROR.get(kind, "raised"), "error": f"{kind}: {error}"}


def _rows_of_judge(wall, head, ways, seconds):
    """Solve a wall that has its own judge in several ways."""
    rows = []
    for solver, precision, accuracy, low_memory in ways:
        if solver != "bpx" or low_memory:
            continue
        way = {"solver": solver, "precision": precision, "accuracy": accuracy}
        way = head | way | {"low_memory": low_memory}
        try:
            with _time_limit(seconds):
                for load, judged in wall.judge(wall, precision, accuracy):
                    p_star = dict(enumerate(wall.loads)).get(load, 0.0)
                    rows.append(way | {"load": load, "p_star": p_star} | judged)
        except Exception as error:  # the campaign continues
            rows.append(way | {"load": 0, "p_star": 0.0} | _failed(error))
    return rows


def rows_of_targets(head, wall, contact, ways, seconds, hardness=None):
    """Solve a wall with prescribed areas or gaps in several ways.

    Parameters
    ----------
    head : dict
        Columns of all rows.
    wall : Wall
        With targets.
    contact : Contact
        Its exact contact.
    ways : list of tuple
        (solver, precision, accuracy, low_memory).
    seconds : float
        Time limit for each target.
    hardness : float, optional
        Hardness over E* g_rms.

    Returns
    -------
    list of dict
        A row for each way and target.
    """
    rows = []
    for solver, precision, accuracy, low_memory in ways:
        if low_memory or solver != "bpx":
            continue
        way = {"solver": solver, "precision": precision, "accuracy": accuracy}
        way = head | way | {"low_memory": low_memory}
        start = None
        for load, value in enumerate(wall.targets[1]):
            begin = time.perf_counter()
            row = way | {"load": load, "target": value, "p_star": 0.0}
            try:
                with _time_limit(seconds), warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    unit = wall.E_star * contact.g_rms
                    solution = _solution_of_target(wall, way, value, hardness and hardness * unit)
                    row["p_star"] = solution.p / wall.E_star / contact.g_rms
                    truth = contact.solve(row["p_star"], start, hardness)
                    start = truth.pressure
                    row |= _judged(solution, truth, contact, wall)
                    if solution.status == "converged":
                        target = wall.targets[0], value, accuracy
                        row |= missed(solution, truth, contact, *target, hardness)
                        row["true"][ERROR_OF_TARGET[wall.targets[0]]] += row["missed"]
            except Exception as error:
                row |= _failed(error)
            rows.append(row | {"seconds": round(time.perf_counter() - begin, 4)})
    return rows


def _solution_of_target(wall, way, value, hardness):
    return hpc_gfmd.solve(
        wall.heights,
        hardness=hardness,
        E_star=wall.E_star,
        physical_sizes=wall.physical_sizes,
        boundary=["free" if ends else "periodic" for ends in wall.free],
        fields=["pressure"],
        precision=way["precision"],
        accuracy=way["accuracy"],
        **{wall.targets[0]: value},
    )


def missed(solution, truth, contact, quantity, value, accuracy, hardness=None):
    """Return by how much a target is missed.

    Parameters
    ----------
    solution : hpc_gfmd.Solution
        Solution of the target.
    truth : Truth
        Exact solution at its load.
    contact : Contact
        Exact contact.
    quantity : str
        "a_r" or "gap_over_h_rms".
    value : float
        The target.
    accuracy : float
        Requested accuracy.
    hardness : float, optional
        Hardness over E* g_rms.

    Returns
    -------
    dict
        missed: relative distance, 0 within the accuracy, within one point of an area, or on the
        nearer side of a jump that the truth has, too; for areas also jump (whether a jump was
        noted) and nearest (nearest number of points).
    """
    if quantity != "a_r":
        h_rms = np.std(contact.h[contact.D])
        relative = abs(truth.gap_mean / h_rms / value - 1)
        return {"missed": float(relative) if relative > accuracy + ROUNDED_TARGET else 0.0}
    target_points = value * contact.N
    distance = abs(round(solution.a_r * contact.N) - target_points)
    row = {"missed": 0.0, "jump": "jumps" in (solution.note or "")}
    if distance <= max(accuracy * target_points, 1) + ROUNDED_TARGET * target_points:
        return row
    nearest = nearest_count(contact, solution.p_star, target_points, hardness)
    row["nearest"] = nearest
    allowed = abs(nearest - target_points) + 1 + truth.ties_in + truth.ties_out
    if not row["jump"] or distance > allowed:
        row["missed"] = distance / target_points
    return row


def nearest_count(contact, p_star, points, hardness=None):
    """Return the number of contact points nearest to a target that loads near p* have.

    It is found by bisection. Contacts with ties are on both sides of a jump and do not count.

    Parameters
    ----------
    contact : Contact
        Exact contact.
    p_star : float
        Load from which the bisection starts.
    points : float
        Target.
    hardness : float, optional
        Hardness over E* g_rms.
    """
    counts = {}
    nearest = np.inf

    def count(p):
        nonlocal nearest
        if p not in counts:
            truth = contact.solve(p, hardness=hardness)
            counts[p] = truth.contact
            ties = truth.ties_in + truth.ties_out
            if ties == 0 and abs(truth.contact - points) < abs(nearest - points):
                nearest = truth.contact
        return counts[p]

    low = p_star
    step = 1e-6
    while count(low) >= points and step < 1:
        low = low / (1 + step)
        step = 4 * step
    high = p_star
    step = 1e-6
    while count(high) < points and step < 1:
        high = high * (1 + step)
        step = 4 * step
    while high / low - 1 > EQUAL_LOADS and abs(nearest - points) > 1:
        middle = np.sqrt(low * high)
        if count(middle) < points:
            low = middle
        else:
            high = middle
    return nearest


def _judged(solution, truth, contact, wall):
    """Return the true and the claimed errors of (area, mean gap, pressure) of a solution."""
    points = round(solution.a_r * wall.heights.size)
    with np.errstate(all="ignore"):
        p = np.asarray(solution.pressure, np.float64) / wall.E_star / contact.g_rms
        true = truth.errors(points, solution.gap_mean / contact.height_unit, p)
    return {
        "contact": truth.contact,
        "kkt": truth.kkt,
        "status": solution.status,
        "true": [float(x) for x in true],
        "claimed": [float(x) for x in solution.errors],
        "iterations": solution.iterations,
        "fft_pairs": round(solution.fft_pairs, 2),
    }


def _solutions(wall, contact, way, hardness):
    """Yield the solutions of the loads; low memory needs a scene."""
    settings = {"name": way["solver"], "precision": way["precision"], "accuracy": way["accuracy"]}
    if way["solver"] != "bpx":
        settings["max_iterations"] = 3000
    loads = [p_star * wall.E_star * contact.g_rms for p_star in wall.loads]
    if not way["low_memory"]:
        yield from hpc_gfmd.solve(
            wall.heights,
            loads,
            E_star=wall.E_star,
            hardness=hardness,
            physical_sizes=wall.physical_sizes,
            boundary=["free" if ends else "periodic" for ends in wall.free],
            fields=["pressure"],
            **settings,
        )
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "contact.h5"
        scene = {
            "surface": wall.surface,
            "material": {} if hardness is None else {"hardness": hardness},
            "load": {"pressure": loads},
            "solver": settings | {"low_memory": True},
            "output": {"path": str(path), "fields": ["pressure"]},
        }
        path.with_suffix(".toml").write_text(tomli_w.dumps(scene))
        hpc_gfmd.run(path.with_suffix(".toml"), quiet=True)
        yield from hpc_gfmd.load(path)


@contextmanager
def _time_limit(seconds):
    """Raise TooSlow after some seconds."""

    def stop(*_):
        raise TooSlow(f"more than {seconds} s")

    previous = signal.signal(signal.SIGALRM, stop)
    signal.alarm(int(seconds))
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, previous)
