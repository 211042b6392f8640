"""The share of g_rms^2 at the shortest waves of a map."""

import re

import numpy as np
import pytest

from hpc_gfmd.surface.bandwidth import bandwidth_line


@pytest.mark.parametrize("n", [96, 1500])
def test_two_waves(n):
    """Waves of 24 and of 3 points with slopes 2:1, so that the short one has a fifth of g_rms^2."""
    x = np.arange(n)
    long, short = (np.sin(2 * np.pi * x / points) * points for points in (24, 3))
    line = bandwidth_line((2 * long + short)[:, None] + 0 * x[:48], (n, 48), "")
    head, share, tail = re.fullmatch(r"(.*) have (\d+) % of g_rms\^2(.*)", line).groups()
    assert head == "waves shorter than 4 (4 points)"
    assert int(share) == pytest.approx(20, abs=1)
    assert "1.1" in tail
    smooth = bandwidth_line(long[:, None] + 0 * x[:48], (n, 48), "")
    assert float(smooth.split(" % of")[0].split()[-1]) < 0.1
    assert bandwidth_line(np.zeros((8, 8)), (1, 1), "") == ""
