"""Light contacts, on few points or in a box, and by iterations on the whole grid, in turn.

Balls on the unit square, smooth and rough (`roughness` is the rms slope that is added), and a rough
piece (`roughness` inf, null in rows), with free edges; radius 1, E* = 1. Periodic walls of a Hurst
exponent (`hurst`). Each at the load with about this contact area. `over_whole` is the median of the
time over that on the whole grid; `pressure_difference` the L2 norm between both.
"""

from contextlib import ExitStack
from unittest import mock

import numpy as np

import hpc_gfmd
from hpc_gfmd.driver import box, few_points

from .contacts import RoughContact, distance, timed_solve
from .report import Report
from .timing import in_turn, ratio, summary

WHOLE = [(box, "SMALLEST", np.inf), (few_points, "MOST", 0.0)]  # what nothing fits in


def run(args):
    """Report each contact in both ways."""
    report = Report("light", args.out)
    for n in args.n:
        for roughness in args.roughness:
            shown = None if np.isinf(roughness) else roughness
            heights = free_heights(n, roughness)
            for row in _rows(heights, args.a_r, args.repeats, boundary="free"):
                report.add(n=n, roughness=shown, hurst=None, **row)
    for n in args.n_walls:
        for hurst in args.hurst:
            wall = RoughContact(n, 0.0, hurst).surface
            for row in _rows(wall, args.a_r_walls, args.repeats):
                report.add(n=n, roughness=None, hurst=hurst, **row)
    report.finish()


def free_heights(n, roughness):
    """Return the heights of a ball with roughness, or of a rough piece."""
    if np.isinf(roughness):
        return np.asarray(RoughContact(n, 0.0, boundary="free").surface.heights)
    x = (np.arange(n) - 0.5 * (n - 1)) / n
    ball = -(x[:, None] ** 2 + x**2) / 2
    if not roughness:
        return ball
    rough = RoughContact(n, 0.0, boundary="free", L_over_lam_l=8, lam_s_over_a=4).surface
    return ball + roughness * np.asarray(rough.heights)


def _rows(heights, areas, repeats, **how):
    """Yield the rows of a surface at loads with these areas, solved in both ways."""
    for a_r in areas:
        load = hpc_gfmd.solve(heights, a_r=a_r, fields=(), **how).p
        rows = {"part": [], "whole": []}
        pressures = {}
        for name in in_turn(rows, repeats + 1):
            with ExitStack() as stack:
                for changed in WHOLE if name == "whole" else ():
                    stack.enter_context(mock.patch.object(*changed))
                row, pressures[name] = timed_solve(heights, pressure=load, **how)
            rows[name].append({"solved": name} | row)
        rows = {name: series[1:] for name, series in rows.items()}  # the first warms up
        times = {name: [row["cpu_seconds"] for row in series] for name, series in rows.items()}
        for name, series in rows.items():
            yield summary(series) | {
                "over_whole": ratio(times[name], times["whole"]),
                "pressure_difference": distance(pressures[name], pressures["whole"]),
            }
