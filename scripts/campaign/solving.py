"""Solve walls of the campaign as a user would, and compare true with claimed errors."""

import signal
import time
import warnings
from contextlib import contextmanager

import numpy as np

import hpc_gfmd
from hpc_gfmd.scene import Scene

from .families import make, outcome
from .registry import keywords
from .truth import truths

ERROR_OF_TARGET = {"a_r": 0, "gap_over_h_rms": 1}  # index of the error of a target
EQUAL_LOADS = 1e-12  # relative difference of loads that count as equal
ROUNDED_TARGET = 1e-9  # relative rounding errors of a target
# Time limit for all truths of a wall, and for all its loads in one way.
SECONDS = 120
MOST_ITERATIONS = 3000  # of other solvers than bpx


class TooSlow(Exception):
    """The loads of a wall and their exact solutions took longer than SECONDS."""


STATUS_OF_ERROR = {"TooSlow": "too slow", "SceneError": "refused"}


def rows_of(name, seed, index, ways, seconds=SECONDS):
    """Solve a wall in several ways (solver, precision, accuracy, low_memory), each within a time
    limit; return a row for each way and load. Errors are rows, too."""
    head = {"family": name, "seed": seed, "index": index}
    try:
        wall = make(name, seed, index)
        with _time_limit(seconds):
            judge = wall.judge or _judge_of(wall)
    except Exception as error:  # the campaign continues
        return [head | {"status": "no wall", "error": f"{type(error).__name__}: {error}"}]
    head["n"] = list(wall.heights.shape)
    rows = []
    for way in ways:
        if _is_possible(wall, *way):
            columns = zip(("solver", "precision", "accuracy", "low_memory"), way, strict=True)
            rows += _rows_of_way(wall, judge, head | dict(columns), seconds)
    return rows


def _is_possible(wall, solver, precision, accuracy, low_memory):
    """Return whether a wall can be solved in a way."""
    is_special = wall.judge is not None or wall.targets is not None
    if low_memory and (is_special or wall.surface is None):
        return False
    is_hard = wall.hardness is not None or wall.hardness_star is not None
    return solver == "bpx" or not (low_memory or is_special or is_hard)


def _rows_of_way(wall, judge, way, seconds):
    """Return the rows of the loads of a wall in one way, the last one with the error, if any."""
    rows = []
    begin = time.perf_counter()
    try:
        with _time_limit(seconds), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for load, columns in judge(wall, way):
                rows.append(way | {"load": load, "p_star": _load(wall, load)} | columns)
    except Exception as error:
        kind = type(error).__name__
        failed = {"status": STATUS_OF_ERROR.get(kind, "raised"), "error": f"{kind}: {error}"}
        rows.append(way | {"load": len(rows), "p_star": _load(wall, len(rows))} | failed)
    if rows:
        rows[-1]["seconds"] = round(time.perf_counter() - begin, 4)
    return rows


def _load(wall, number):
    """Return a load of a wall; 0 where it follows from a target."""
    return wall.loads[number] if number < len(wall.loads) else 0.0


def _judge_of(wall):
    """Return the judge of a wall by the exact solutions of its loads or of its targets."""
    contact, exact, hardness = truths(
        wall.heights, wall.physical_sizes, wall.loads, wall.free, wall.hardness, wall.hardness_star
    )
    judged = _judged_loads if wall.targets is None else _judged_targets
    return lambda wall, way: judged(wall, way, contact, exact, hardness)


def _judged_loads(wall, way, contact, exact, hardness):
    """Yield (number of the load, columns) of each load."""
    if hardness is not None:
        hardness *= wall.E_star * contact.g_rms
    solutions = _solutions(wall, contact, way, hardness)
    for number, (solution, truth) in enumerate(zip(solutions, exact)):
        yield number, _judged(solution, truth, contact, wall)


def _judged_targets(wall, way, contact, exact, hardness):
    """Yield (number of the target, columns) of each prescribed area or gap."""
    unit = wall.E_star * contact.g_rms
    quantity, values = wall.targets
    start = None
    for number, value in enumerate(values):
        solution = hpc_gfmd.solve(
            wall.heights,
            hardness=hardness and hardness * unit,
            precision=way["precision"],
            accuracy=way["accuracy"],
            fields=["pressure"],
            **keywords(wall),
            **{quantity: value},
        )
        p_star = solution.p / wall.E_star / contact.g_rms
        truth = contact.solve(p_star, start, hardness)
        start = truth.pressure
        columns = {"target": value, "p_star": p_star} | _judged(solution, truth, contact, wall)
        if solution.status == "converged":
            columns |= missed(solution, truth, contact, quantity, value, way["accuracy"], hardness)
            columns["true"][ERROR_OF_TARGET[quantity]] += columns["missed"]
        yield number, columns


def missed(solution, truth, contact, quantity, value, accuracy, hardness=None):
    """Return by how much a target (a_r or gap_over_h_rms) is missed by a solution, whose truth is
    that of its load.

    missed: relative distance, 0 within the accuracy, within one point of an area, or on the nearer
    side of a jump that the truth has, too. For areas also jump (whether a jump was noted) and
    nearest (nearest number of points). The hardness is over E* g_rms.
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
    p_star = solution.p_star
    nearest = nearest_count(contact, p_star, target_points, hardness)
    row["nearest"] = nearest
    allowed = abs(nearest - target_points) + 1 + truth.ties_in + truth.ties_out
    if not row["jump"] or distance > allowed:
        row["missed"] = distance / target_points
    return row


def nearest_count(contact, p_star, points, hardness=None):
    """Return the number of contact points nearest to a target that loads near p* have, by
    bisection. Contacts with ties are on both sides of a jump and do not count."""
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
    """Return the columns of a solution with a truth."""
    true = contact.errors_of(solution, truth, wall.E_star)
    return {"kkt": truth.kkt} | outcome(solution, truth.contact, true)


def _solutions(wall, contact, way, hardness):
    """Return the solutions of the loads; low memory makes the heights from a scene."""
    settings = {key: way[key] for key in ("precision", "accuracy")} | {"name": way["solver"]}
    if way["solver"] != "bpx":
        settings["max_iterations"] = MOST_ITERATIONS
    settings |= {"hardness": hardness, "fields": ["pressure"]}
    loads = [p_star * wall.E_star * contact.g_rms for p_star in wall.loads]
    if way["low_memory"]:
        scene = Scene.from_dict({"surface": wall.surface, "load": {"pressure": loads}})
        return hpc_gfmd.solve(scene, low_memory=True, **settings)
    return hpc_gfmd.solve(wall.heights, loads, **settings, **keywords(wall))


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
