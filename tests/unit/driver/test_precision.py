"""The precision of loads: rules, and agreement of the forecast with a sweep."""

import numpy as np
import pytest
from contacts import rough, sweep_of

import hpc_gfmd
from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.precision import first_precision, known_heights, known_p_stars, precisions
from hpc_gfmd.scene import Scene, SolverTable

SINGLE = np.dtype(np.float32)
DOUBLE = np.dtype(np.float64)


@pytest.mark.parametrize(
    ("settings", "dtype"),
    [
        ({"accuracy": 1e-3}, SINGLE),
        ({"accuracy": 1e-5}, DOUBLE),
        ({"residual": 1e-3}, DOUBLE),
        ({"accuracy": 1e-5, "precision": "single"}, SINGLE),
        ({"accuracy": 1e-1, "precision": "double"}, DOUBLE),
    ],
)
def test_first_precision(settings, dtype):
    assert first_precision(SolverTable(**settings)) == dtype


@pytest.mark.parametrize(("p_star", "dtypes"), [([0.1, 0.3, 0.2], [DOUBLE] * 3), ([0.3], [SINGLE])])
def test_loads_that_leave_errors_to_later_ones(p_star, dtypes):
    """Forecast and use of a higher precision where dents stay."""
    surface = rough((2, 32, 2))
    load = {"p_star": p_star, "history": True}
    scene = {"surface": surface, "load": load, "material": {"hardness": 0.5}}
    assert precisions(Scene.from_dict(scene), (128, 128)) == dtypes
    solutions = hpc_gfmd.solve(
        hpc_gfmd.make_surface(**surface), p_star=p_star, history=True, hardness=0.5
    )
    assert [solution.precision for solution in solutions] == [dtype.name for dtype in dtypes]


@pytest.mark.parametrize("p_star", [[0.3, 0.2], [0.3, 1e-4, 0.3]])
def test_forecast_agrees_with_a_sweep(p_star):
    surface = rough((2, 32, 2))
    solver = {"accuracy": 2e-3}
    scene = Scene.from_dict({"surface": surface, "load": {"p_star": p_star}, "solver": solver})
    forecast = precisions(scene, scene.surface.n)
    sweep = sweep_of(surface, **solver)
    used = [sweep.solve(p * sweep.surface.g_rms).g.dtype for p in p_star]
    assert [dtype or SINGLE for dtype in forecast] == used


@pytest.mark.parametrize(("hardness", "dtype"), [(1e-6, DOUBLE), (0.3, SINGLE)])
def test_soft_bodies_are_not_tried_in_single_precision(hardness, dtype):
    """Every FFT pair is one of double precision."""
    surface = rough((2, 32, 2))
    p_mean = 0.3 * hardness
    material = {"hardness": hardness}
    scene = Scene.from_dict(
        {
            "surface": surface,
            "load": {"pressure": p_mean},
            "solver": {"accuracy": 1e-2},
            "material": material,
        }
    )
    (forecast,) = precisions(scene, scene.surface.n)
    assert (forecast or SINGLE) == dtype
    contact = sweep_of(surface, accuracy=1e-2, layer=material).solve(Load("pressure", p_mean))
    assert contact.g.dtype == dtype
    if dtype == DOUBLE:
        double = sweep_of(surface, accuracy=1e-2, precision="double", layer=material)
        assert contact.fft_pairs == double.solve(Load("pressure", p_mean)).fft_pairs


@pytest.mark.parametrize(
    ("load", "g_rms", "known"),
    [
        ({"p_star": [0.1, 0.2]}, None, [0.1, 0.2]),
        ({"a_r": [0.2, 0.1]}, None, [0.1, 0.05]),
        ({"gap_mean": ["1 um", "2 um", "3 um"]}, 0.5, [None, None, None]),
        ({"pressure": ["1 MPa", "2 MPa"]}, None, [None, None]),
        ({"pressure": ["1 MPa", "2 MPa"]}, 0.5, [0.001, 0.002]),
    ],
)
def test_loads_that_are_known_beforehand(load, g_rms, known):
    surface = rough((2, 32, 2)) | {"physical_sizes": ["1 mm", "1 mm"]}
    scene = {"surface": surface, "load": load, "material": {"E_star": "2 GPa"}}
    p_stars = known_p_stars(Scene.from_dict(scene), g_rms)
    assert p_stars == [p and pytest.approx(p) for p in known]


def test_heights_that_are_known_beforehand():
    """Of a map and of waves on a ball nothing is known; else slope and height, the latter to a few
    per cent."""
    for surface in (
        {"kind": "file", "path": "x.npy"},
        rough((2, 32, 2)) | {"radius": 5.0, "boundary": "free"},
    ):
        scene = Scene.from_dict({"surface": surface, "load": {"p_star": 0.1}})
        assert known_heights(scene, (128, 128)) == (None, None)
    for surface in (rough((4, 32, 2)), {"kind": "wave", "n": [128, 128], "amplitude": 0.01}):
        scene = Scene.from_dict({"surface": surface, "load": {"p_star": 0.1}})
        made = sweep_of(surface).surface
        g_rms, height = known_heights(scene, (256, 256))
        assert g_rms == pytest.approx(made.g_rms, rel=0.01)
        assert height * g_rms / 256 == pytest.approx(made.h_rms, rel=0.1)
