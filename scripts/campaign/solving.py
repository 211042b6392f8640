"""Solve walls of the campaign as a user would, and compare true with claimed errors."""

import signal
import time
import warnings
from contextlib import contextmanager

import hpc_gfmd
from hpc_gfmd.scene import Scene

from .families import make
from .registry import compared, keywords
from .truth import truths

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
    if low_memory and (wall.judge or wall.surface is None):
        return False
    is_hard = wall.hardness is not None or wall.hardness_star is not None
    return solver == "bpx" or not (low_memory or wall.judge or is_hard)


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
    """Return the judge of a wall by the exact solutions of its loads."""
    contact, exact, hardness = truths(
        wall.heights, wall.physical_sizes, wall.loads, wall.free, wall.hardness, wall.hardness_star
    )
    limit = hardness and hardness * wall.E_star * contact.g_rms

    def judged_loads(wall, way):
        solutions = _solutions(wall, contact, way, limit)
        for number, (solution, truth) in enumerate(zip(solutions, exact)):
            yield number, compared(solution, truth, contact, wall.E_star)

    return judged_loads


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
