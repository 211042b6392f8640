"""Solve a wall of the campaign as a user would, and say how far from the truth it is and how far it
says it is."""

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
from .kept import truths
from .sticky_walls import judged_rows

KIND = {"a_r": 0, "gap_over_h_rms": 1}  # which of the three errors a target is of
MEET = 1e-12  # relative: loads that are the same
ROUNDED_TARGET = 1e-9  # relative rounding errors of a target
# for all truths of one wall, and for all its loads by one solver in one precision to one accuracy
SECONDS = 120


class TooSlow(Exception):
    """A solve took longer than SECONDS."""


FAILURES = {"TooSlow": "too slow", "SceneError": "refused"}


def rows_of(name, seed, index, ways, seconds=SECONDS):
    """Solve a wall: a row for each way (solver, precision, accuracy, low_memory) and load; failures
    are rows too."""
    head = {"family": name, "seed": seed, "index": index}
    try:
        wall = make(name, seed, index)
        if wall.attraction is not None:
            head["n"] = list(wall.heights.shape)
            return _sticky_rows(wall, head, ways, seconds)
        with _time_limit(seconds):
            of = wall.heights, wall.physical_sizes, wall.loads, wall.free, wall.hardness
            contact, exact, hardness = truths(*of, wall.hardness_star)
    except Exception as error:  # a campaign goes on
        return [head | {"status": "no wall", "error": f"{type(error).__name__}: {error}"}]
    head["n"] = list(wall.heights.shape)
    if wall.targets is not None:
        return rows_of_targets(head, wall, contact, ways, seconds)
    rows = []
    if hardness is not None:
        hardness *= wall.E_star * contact.g_rms
    for solver, precision, accuracy, low_memory in ways:
        if (low_memory and wall.surface is None) or (solver != "bpx" and (low_memory or hardness)):
            continue
        way = {"solver": solver, "precision": precision, "accuracy": accuracy}
        way = head | way | {"low_memory": low_memory}
        begun, loads = time.perf_counter(), iter(enumerate(wall.loads))
        try:
            with _time_limit(seconds), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                for found, truth in zip(_solutions(wall, contact, way, hardness), exact):
                    load, p_star = next(loads)
                    judged = _judged(found, truth, contact, wall)
                    rows.append(way | {"load": load, "p_star": p_star} | judged)
        except Exception as error:
            kind = type(error).__name__
            load, p_star = next(loads, (0, wall.loads[0]))
            failed = {"status": FAILURES.get(kind, "raised"), "error": f"{kind}: {error}"}
            rows.append(way | {"load": load, "p_star": p_star} | failed)
        rows[-1]["seconds"] = round(time.perf_counter() - begun, 4)
    return rows


def _sticky_rows(wall, head, ways, seconds):
    """Solve a wall with an attraction, see sticky_walls.py."""
    rows = []
    for solver, precision, accuracy, low_memory in ways:
        if solver != "bpx" or low_memory:
            continue
        way = {"solver": solver, "precision": precision, "accuracy": accuracy}
        way = head | way | {"low_memory": low_memory}
        try:
            with _time_limit(seconds):
                for load, judged in judged_rows(wall, precision, accuracy):
                    rows.append(way | {"load": load, "p_star": wall.loads[load]} | judged)
        except Exception as error:  # a campaign goes on
            kind = type(error).__name__
            failed = {"status": FAILURES.get(kind, "raised"), "error": f"{kind}: {error}"}
            rows.append(way | {"load": 0, "p_star": wall.loads[0]} | failed)
    return rows


def rows_of_targets(head, wall, contact, ways, seconds):
    """Solve a wall whose loads are prescribed: a row for each way and target."""
    rows = []
    for solver, precision, accuracy, low_memory in ways:
        if low_memory or solver != "bpx":
            continue
        way = {"solver": solver, "precision": precision, "accuracy": accuracy}
        way = head | way | {"low_memory": low_memory}
        start = None
        for load, value in enumerate(wall.targets[1]):
            begun = time.perf_counter()
            row = way | {"load": load, "target": value, "p_star": 0.0}
            try:
                with _time_limit(seconds), warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    found = _solution_of_target(wall, way, value)
                    row["p_star"] = found.p / wall.E_star / contact.g_rms
                    truth = contact.solve(row["p_star"], start)
                    start = truth.pressure
                    row |= _judged(found, truth, contact, wall)
                    if found.status == "converged":
                        row |= missed(found, truth, contact, wall.targets[0], value, accuracy)
                        row["true"][KIND[wall.targets[0]]] += row["missed"]
            except Exception as error:
                kind = type(error).__name__
                row |= {"status": FAILURES.get(kind, "raised"), "error": f"{kind}: {error}"}
            rows.append(row | {"seconds": round(time.perf_counter() - begun, 4)})
    return rows


def _solution_of_target(wall, way, value):
    return hpc_gfmd.solve(
        wall.heights,
        E_star=wall.E_star,
        physical_sizes=wall.physical_sizes,
        boundary=["free" if ends else "periodic" for ends in wall.free],
        fields=["pressure"],
        precision=way["precision"],
        accuracy=way["accuracy"],
        **{wall.targets[0]: value},
    )


def missed(found, truth, contact, quantity, value, accuracy):
    """Return by how much a target is missed, relative: 0 within the accuracy, or one point of an
    area, or at the nearer side of a jump that the truth has, too."""
    if quantity != "a_r":
        h_rms = np.std(contact.h[contact.D])
        missed = abs(truth.gap_mean / h_rms / value - 1)
        return {"missed": float(missed) if missed > accuracy + ROUNDED_TARGET else 0.0}
    points = value * contact.N
    n = round(found.a_r * contact.N)
    off = abs(n - points)
    row = {"missed": 0.0, "jump": "jumps" in (found.note or "")}
    if off <= max(accuracy * points, 1) + ROUNDED_TARGET * points:
        return row
    nearest = nearest_count(contact, found.p_star, points)
    row["nearest"] = nearest
    if not row["jump"] or off > abs(nearest - points) + 1 + truth.ties_in + truth.ties_out:
        row["missed"] = off / points
    return row


def nearest_count(contact, p_star, points):
    """Return the number of points in contact nearest to `points` that a load has near p*, by
    bisection; a contact in which points just touch is on both sides of a jump, and counts for
    none."""
    counts, nearest = {}, np.inf

    def count(p):
        nonlocal nearest
        if p not in counts:
            truth = contact.solve(p)
            counts[p] = truth.contact
            ties = truth.ties_in + truth.ties_out
            if ties == 0 and abs(truth.contact - points) < abs(nearest - points):
                nearest = truth.contact
        return counts[p]

    low, high, step = p_star, p_star, 1e-6
    while count(low) >= points and step < 1:
        low, step = low / (1 + step), 4 * step
    step = 1e-6
    while count(high) < points and step < 1:
        high, step = high * (1 + step), 4 * step
    while high / low - 1 > MEET and abs(nearest - points) > 1:
        middle = np.sqrt(low * high)
        if count(middle) < points:
            low = middle
        else:
            high = middle
    return nearest


def _judged(found, truth, contact, wall):
    """Compare true and claimed errors of (area, mean gap, pressure) of a hpc_gfmd.Solution."""
    points = round(found.a_r * wall.heights.size)
    with np.errstate(all="ignore"):
        p = np.asarray(found.pressure, np.float64) / wall.E_star / contact.g_rms
        true = truth.errors(points, found.gap_mean / contact.height_unit, p)
    return {
        "contact": truth.contact,
        "kkt": truth.kkt,
        "status": found.status,
        "true": [float(x) for x in true],
        "claimed": [float(x) for x in found.errors],
        "iterations": found.iterations,
        "fft_pairs": round(found.fft_pairs, 2),
    }


def _solutions(wall, contact, way, hardness):
    """Yield the hpc_gfmd.Solution of one load after the other; low memory works from a scene
    alone."""
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
    def stop(*_):
        raise TooSlow(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(int(seconds))
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
