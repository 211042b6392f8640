"""Light contacts with free edges, solved in a box and on the whole grid, in turn.

Balls on the unit square, smooth and rough (`roughness` is the rms slope that is added), and a rough
piece (`roughness` inf, null in rows); radius 1, E* = 1, at the load with about this contact area.
`over_whole` is the median of the time over that on the whole grid; `pressure_difference` the L2
norm between both.
"""

from unittest import mock

import numpy as np

import hpc_gfmd
from hpc_gfmd.driver import box

from .contacts import RoughContact, distance, timed_solve
from .report import Report
from .timing import in_turn, ratio, summary


def run(args):
    """Report each contact in a box and on the whole grid."""
    report = Report("light", args.out)
    for n in args.n:
        for roughness in args.roughness:
            heights = _heights(n, roughness)
            for a_r in args.a_r:
                load = hpc_gfmd.solve(heights, a_r=a_r, boundary="free", fields=()).p
                for row in _rows(heights, load, args.repeats):
                    shown = None if np.isinf(roughness) else roughness
                    report.add(n=n, roughness=shown, **row)
    report.finish()


def _heights(n, roughness):
    """Return the heights of a ball with roughness, or of a rough piece."""
    if np.isinf(roughness):
        return np.asarray(RoughContact(n, 0.0, boundary="free").surface.heights)
    x = (np.arange(n) - 0.5 * (n - 1)) / n
    ball = -(x[:, None] ** 2 + x**2) / 2
    if not roughness:
        return ball
    rough = RoughContact(n, 0.0, boundary="free", L_over_lam_l=8, lam_s_over_a=4).surface
    return ball + roughness * np.asarray(rough.heights)


def _rows(heights, load, repeats):
    """Yield the rows of a contact in a box and on the whole grid."""
    smallest = {"box": box.SMALLEST, "whole": np.inf}
    rows = {name: [] for name in smallest}
    pressures = {}
    for name in in_turn(smallest, repeats + 1):
        with mock.patch.object(box, "SMALLEST", smallest[name]):
            row, pressures[name] = timed_solve(heights, pressure=load, boundary="free")
        rows[name].append({"solved": name} | row)
    rows = {name: series[1:] for name, series in rows.items()}  # the first warms up
    times = {name: [row["cpu_seconds"] for row in series] for name, series in rows.items()}
    for name, series in rows.items():
        yield summary(series) | {
            "over_whole": ratio(times[name], times["whole"]),
            "pressure_difference": distance(pressures[name], pressures["whole"]),
        }
