"""The precision of loads: rules, and agreement of the forecast with a sweep."""

import numpy as np
import pytest
from contacts import rough, sweep_of

import hpc_gfmd
from hpc_gfmd.driver.precision_forecast import known_heights, known_p_stars, precisions
from hpc_gfmd.scene import Scene

SINGLE = np.dtype(np.float32)
DOUBLE = np.dtype(np.float64)


LOOSE = {"accuracy": 2e-3}
SOFT = {"accuracy": 1e-2}  # solver of bodies that are softer than the wall is steep
SWEEPS = [  # load, material, solver, precisions
    ({"p_star": [0.3, 0.2]}, {}, LOOSE, [SINGLE, SINGLE]),
    ({"p_star": [0.3, 1e-4, 0.3]}, {}, LOOSE, [SINGLE, DOUBLE, DOUBLE]),
    ({"p_star": 0.3}, {}, {"accuracy": 1e-5}, [DOUBLE]),
    ({"p_star": 0.3}, {}, {"residual": 1e-3}, [DOUBLE]),
    ({"p_star": 0.3}, {}, {"accuracy": 1e-5, "precision": "single"}, [SINGLE]),
    ({"p_star": 0.3}, {}, {"accuracy": 1e-1, "precision": "double"}, [DOUBLE]),
    # errors are left to later loads where dents stay
    ({"p_star": [0.1, 0.3, 0.2], "history": True}, {"hardness": 0.5}, {}, [DOUBLE] * 3),
    ({"p_star": [0.3], "history": True}, {"hardness": 0.5}, {}, [SINGLE]),
    ({"pressure": 3e-7}, {"hardness": 1e-6}, SOFT, [DOUBLE]),
    ({"pressure": 0.09}, {"hardness": 0.3}, SOFT, [SINGLE]),
]


def test_forecast_and_use_of_precisions():
    """Soft bodies are not tried in single precision: every FFT pair is one of double."""
    for load, material, solver, dtypes in SWEEPS:
        tables = {"surface": rough((2, 32, 2)), "load": load, "material": material}
        scene = Scene.from_dict(tables | {"solver": solver})
        forecast = precisions(scene, scene.surface.n)
        assert [dtype or SINGLE for dtype in forecast] == dtypes
        solutions = hpc_gfmd.solve(scene)
        assert [solution.precision for solution in solutions] == [dtype.name for dtype in dtypes]
        if solver is SOFT and dtypes == [DOUBLE]:
            (in_double,) = hpc_gfmd.solve(scene, precision="double")
            assert solutions[0].fft_pairs == in_double.fft_pairs


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
