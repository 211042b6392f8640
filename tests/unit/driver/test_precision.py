"""In which precision a load is solved: what is said beforehand is what a sweep does."""

import numpy as np
import pytest
from contacts import rough, sweep_of

from hpc_gfmd.driver.precision import few_points, first_precision, precisions, too_little
from hpc_gfmd.scene import Scene, SolverTable

SINGLE, DOUBLE = np.dtype(np.float32), np.dtype(np.float64)


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
def test_the_first_precision(settings, dtype):
    assert first_precision(SolverTable(**settings)) == dtype


def test_few_points_that_touch_need_double():
    """A point more or less is an error of the area."""
    assert few_points(64**2, 1e-3, 1e-3)
    assert not few_points(4096**2, 0.1, 1e-3)
    assert not few_points(64**2, 1e-3, None)  # a residual has no such error
    assert few_points(1000, 0.4, 1e-3) <= too_little(SolverTable(accuracy=1e-3), 1000, 0.4)


@pytest.mark.parametrize("p_star", [[0.3, 0.2], [0.3, 1e-4, 0.3]])
def test_what_is_said_beforehand_is_what_is_done(p_star):
    surface, solver = rough((2, 32, 2)), {"accuracy": 2e-3}
    scene = Scene.from_dict({"surface": surface, "load": {"p_star": p_star}, "solver": solver})
    said = precisions(scene, scene.surface.n)
    sweep = sweep_of(surface, **solver)
    done = [sweep.solve(p * sweep.surface.g_rms).g.dtype for p in p_star]
    assert [dtype or SINGLE for dtype in said] == done
