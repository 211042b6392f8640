"""Solve a wall of the campaign as a user would, and say how far from the truth it is and how far it
says it is."""

import signal
import time
import warnings

import numpy as np

from .families import make
from .kept import truths

# for all truths of one wall, and for all its loads by one solver in one precision to one accuracy
SECONDS = 120


class TooSlow(Exception):
    """A solve took longer than SECONDS."""


def rows_of(name, seed, index, ways, seconds=SECONDS):
    """One dictionary for each way (solver, precision, accuracy, low_memory) and load of a wall;
    failures are rows too."""
    head = {"family": name, "seed": seed, "index": index}
    try:
        wall = make(name, seed, index)
        with _time_limit(seconds):
            contact, exact = truths(wall.heights, wall.physical_sizes, wall.loads, wall.free)
    except Exception as error:  # a campaign goes on
        return [head | {"status": "no wall", "error": f"{type(error).__name__}: {error}"}]
    head |= {
        "n": list(wall.heights.shape),
        "aspect": wall.physical_sizes[1] / wall.physical_sizes[0],
    }
    rows = []
    for solver, precision, accuracy, low_memory in ways:
        if low_memory and (wall.surface is None or solver != "bpx"):
            continue
        way = head | {
            "solver": solver,
            "precision": precision,
            "accuracy": accuracy,
            "low_memory": low_memory,
        }
        begun, done = time.perf_counter(), 0
        try:
            with _time_limit(seconds), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                for k, (found, truth) in enumerate(zip(_solutions(wall, contact, way), exact)):
                    exactly = {
                        "contact": truth.contact,
                        "gap": truth.gap_mean,
                        "kkt": truth.kkt,
                        "ties": [truth.ties_in, truth.ties_out],
                    }
                    rows.append(
                        way
                        | {"load": k, "p_star": wall.loads[k]}
                        | exactly
                        | _judged(found, truth, contact, wall)
                    )
                    done = k + 1
        except Exception as error:
            failure = {"TooSlow": "too slow", "SceneError": "refused"}.get(
                type(error).__name__, "raised"
            )
            rows.append(
                way
                | {
                    "load": done,
                    "p_star": wall.loads[min(done, len(wall.loads) - 1)],
                    "status": failure,
                    "error": f"{type(error).__name__}: {error}",
                }
            )
        rows[-1]["seconds"] = round(time.perf_counter() - begun, 4)
    return rows


def _judged(found, truth, contact, wall):
    """True and claimed errors of (area, mean gap, pressure)."""
    points, gap_mean, pressure, status, claimed, iterations, pairs = found
    with np.errstate(all="ignore"):
        p = np.asarray(pressure, np.float64) / wall.E_star / contact.g_rms
        true = truth.errors(points, float(gap_mean) / contact.height_unit, p)
    return {
        "status": status,
        "true": [float(x) for x in true],
        "claimed": [float(x) for x in claimed],
        "points": int(points),
        "iterations": int(iterations),
        "fft_pairs": round(float(pairs), 2),
    }


def _solutions(wall, contact, way):
    """(points, gap_mean, pressure, status, claimed errors, iterations, pairs) of one load after the
    other."""
    settings = {"name": way["solver"], "precision": way["precision"], "accuracy": way["accuracy"]}
    if way["solver"] != "bpx":
        settings["max_iterations"] = 3000
    pressures = [p_star * wall.E_star * contact.g_rms for p_star in wall.loads]
    if len(pressures) == 1 and not way["low_memory"]:
        yield _by_solve(wall, pressures[0], settings)
        return
    sweep = _sweep(wall, settings, way["low_memory"])
    for p in pressures:
        c = sweep.solve(p)
        points = round(
            c.contact_points / c.N * contact.N
        )  # of the whole wall, where an axis was left out
        yield (
            points,
            c.gap_mean,
            np.asarray(c.field("pressure")),
            c.status,
            c.certificate.errors,
            c.iterations,
            c.fft_pairs,
        )


def _by_solve(wall, pressure, settings):
    import hpc_gfmd

    boundary = ["free" if ends else "periodic" for ends in wall.free]
    s = hpc_gfmd.solve(
        wall.heights,
        pressure,
        E_star=wall.E_star,
        physical_sizes=wall.physical_sizes,
        boundary=boundary,
        **settings,
    )
    return (
        round(s.a_r * wall.heights.size),
        s.gap_mean,
        s.pressure,
        s.status,
        s.errors,
        s.iterations,
        s.fft_pairs,
    )


def _sweep(wall, settings, low_memory):
    from contacts import sweep_of, sweep_over

    if low_memory:
        return sweep_of(wall.surface, wall.E_star, low_memory=True, **settings)
    return sweep_over(wall.heights, wall.physical_sizes, wall.free, E_star=wall.E_star, **settings)


class _time_limit:
    def __init__(self, seconds):
        self.seconds = seconds

    def __enter__(self):
        def stop(*_):
            raise TooSlow(f"more than {self.seconds} s")

        self.before = signal.signal(signal.SIGALRM, stop)
        signal.alarm(int(self.seconds))

    def __exit__(self, *_):
        signal.alarm(0)
        signal.signal(signal.SIGALRM, self.before)
