"""Moves of whole lines of memory."""

import numpy as np

from hpc_gfmd.kernels.jit import kernel
from hpc_gfmd.kernels.lines import WIDTH, move_line


@kernel
def moved_line(target, i, source, j):
    move_line(target, i, source, j)


def test_move_line(random):
    source = random.random(3 * WIDTH)
    target = np.zeros(3 * WIDTH)
    moved_line(target, 5, source, 3)
    assert np.array_equal(target[5 : 5 + WIDTH], source[3 : 3 + WIDTH])
    assert not target[:5].any()
    assert not target[5 + WIDTH :].any()
