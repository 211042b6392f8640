"""The gap mode, the deflation vector of the preconditioner: it saves FFT pairs at small loads."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import rough, solve_scene

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.operators import deflation
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel.grid import Grid, _kept

N = (144, 160)


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_gap_mode_saves_pairs_at_small_loads(boundary, monkeypatch):
    """Means over three surfaces: 9.5 (periodic) and 10.2 (free) instead of 13.8 and 15.5."""
    means = []
    usual = deflation.CALIBRATION
    for fewest in (usual.fewest, np.inf):
        monkeypatch.setattr(deflation, "CALIBRATION", replace(usual, fewest=fewest))
        _kept.tables.cache_clear()
        walls = [rough((2, 64, 2), seed=seed, boundary=boundary) for seed in (1, 2, 3)]
        means.append(np.mean([solve_scene(wall, 3e-4, accuracy=1e-3).fft_pairs for wall in walls]))
    assert means[0] < 0.8 * means[1]


def test_gap_mode_is_off_for_small_grids_and_extreme_areas():
    """It is off on small grids, without contact and in full contact."""
    mode = Multilevel(Grid(N), HALF_SPACE, np.float64, N[0]).gap_mode
    assert [mode.wanted(share) for share in (0.0, 1e-4, 0.1, 0.5, 1.0)] == [
        False,
        True,
        True,
        True,
        False,
    ]
    assert (mode.find(np.full((18, 20), 0.1)) == 0).all()  # a constant mode is in M
    assert not Multilevel(Grid((96, 96)), HALF_SPACE, np.float64, 96).gap_mode.wanted(0.1)
