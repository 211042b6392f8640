"""Persson's theory beside a measured map, by its own slope and spectrum."""

import numpy as np
import pytest
from contacts import rough

import hpc_gfmd
from hpc_gfmd.plotting.view import View


def test_a_map_has_the_theory_of_the_wall_that_it_shows():
    """Only on request; the gap where the spectrum of the heights is known; the range is named."""
    keys = rough((2, 8, 4), g_rms=0.1, physical_sizes=["8 um", "8 um"])
    wall = hpc_gfmd.make_surface(**keys)
    scan = hpc_gfmd.prepare_surface(
        wall.heights, physical_sizes=wall.sizes, unit="m", boundary="periodic"
    )
    spectrum = {"fields": (), "distributions": ["heights_spectrum"]}
    pressures = ["2 MPa", "20 MPa"]
    known = View(hpc_gfmd.solve(wall, pressures, "1 GPa", **spectrum).result, [0, 1]).theory
    results = [hpc_gfmd.solve(scan, pressures, "1 GPa", **how).result for how in (spectrum, {})]
    assert View(results[0], [0, 1]).theory is None
    by_spectrum, by_slope = (View(result, [0, 1], persson=True).theory for result in results)
    p = np.array([2e6, 2e7])
    assert by_spectrum.curves["a_r"](p) == pytest.approx(known.curves["a_r"](p), rel=1e-3)
    assert by_spectrum.curves["gap_mean"](p) == pytest.approx(known.curves["gap_mean"](p), rel=0.05)
    assert "gap_mean" not in by_slope.curves
    assert "= 0.1, waves of 0.25 to 8 um" in by_slope.name
