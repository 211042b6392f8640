"""Persson's theory beside a measured map, by its own slope and spectrum."""

import numpy as np
import pytest
from contacts import rough

import hpc_gfmd
from hpc_gfmd.plotting.theory import theory_beside
from hpc_gfmd.theory import persson


def test_a_map_has_the_theory_of_the_wall_that_it_shows():
    """Only on request; the gap where the spectrum of the heights is known; the range is named."""
    keys = rough((2, 8, 4), g_rms=0.1, physical_sizes=["8 um", "8 um"])
    wall = hpc_gfmd.make_surface(**keys)
    scan = hpc_gfmd.prepare_surface(
        wall.heights, physical_sizes=wall.sizes, unit="m", boundary="periodic"
    )
    spectrum = {"fields": (), "distributions": ["heights_spectrum"]}
    pressures = ["2 MPa", "20 MPa"]
    known = theory_beside(
        hpc_gfmd.solve(wall, pressures, "1 GPa", **spectrum).result, of_maps=False
    )
    results = [hpc_gfmd.solve(scan, pressures, "1 GPa", **how).result for how in (spectrum, {})]
    assert theory_beside(results[0], of_maps=False) is None
    by_spectrum, by_slope = (theory_beside(result, of_maps=True) for result in results)
    p = np.array([2e6, 2e7])
    assert by_spectrum.curves["a_r"](p) == pytest.approx(known.curves["a_r"](p), rel=1e-3)
    assert by_spectrum.curves["gap_mean"](p) == pytest.approx(known.curves["gap_mean"](p), rel=0.05)
    assert "gap_mean" not in by_slope.curves
    assert "= 0.1, waves of 0.25 to 8 µm" in by_slope.name


def test_show_has_the_theory_beside_the_numbers(cli, tmp_path):
    """Area, and the gap where the spectrum of the heights is known; Hertz beside a ball."""
    scan = hpc_gfmd.prepare_surface(
        hpc_gfmd.make_surface(**rough((2, 8, 4))).heights, boundary="periodic"
    )
    paths = []
    for distributions in (["heights_spectrum"], []):
        loads = hpc_gfmd.solve(scan, p_star=[0.02, 0.1], fields=(), distributions=distributions)
        paths.append(loads.save(tmp_path / f"{len(paths)}.h5"))
    theory = cli.data("show --persson", paths[0])["theory"]
    areas = [step["a_r"] for step in theory["steps"]]
    assert areas == pytest.approx(persson.contact_area(np.array([0.02, 0.1])))
    gaps = [step["gap_mean"] for step in theory["steps"]]
    assert gaps == pytest.approx(loads.gap_mean, rel=0.25)
    shown = cli.prints("show --persson", paths[1])
    assert "theory: Persson, g_rms = 1, waves of" in shown
    assert "heights_spectrum" in shown
    ball = hpc_gfmd.make_surface("sphere", radius=1.0, n=(32, 32), boundary="free")
    of_ball = hpc_gfmd.solve(ball, 0.01, fields=()).save(tmp_path / "ball.h5")
    (step,) = cli.data("show --persson", of_ball)["theory"]["steps"]
    assert step["a_r"] == pytest.approx(hpc_gfmd.load(of_ball)[0].a_r_corrected, rel=0.1)
    pad = hpc_gfmd.prepare_surface(scan.heights, boundary="free")
    of_pad = hpc_gfmd.solve(pad, 0.01, fields=()).save(tmp_path / "pad.h5")
    assert "--persson: found a surface without a theory" in cli.refused("show --persson", of_pad)
