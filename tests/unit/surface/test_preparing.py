"""Preparation of height maps: detrending, filling, cropping, resampling."""

import numpy as np
import pytest
from contacts import random_heights

from hpc_gfmd.scene import File
from hpc_gfmd.surface.prepare import prepare
from hpc_gfmd.surface.topography import open_topography
from hpc_gfmd.util.errors import SceneError

N = (14, 10)
SIZES = (2.0, 1.0)
X, Y = np.meshgrid(np.arange(14) / 7, np.arange(10) / 10, indexing="ij")
PLANE = 5 + 3 * X - 2 * Y
BOWL = 5 + 3 * X - 2 * Y + X * X - X * Y + 4 * Y * Y


@pytest.fixture
def prepared(tmp_path):
    """prepared(z, **keys) prepares heights by keys of [surface].

    It returns the heights, the Topography and the list of steps.
    """

    def call(z, boundary="periodic", **keys):
        path = tmp_path / "z.npy"
        np.save(path, z)
        keys |= {"boundary": boundary, "physical_sizes": SIZES}
        spec = File(kind="file", path=str(path), **keys)
        surface = prepare(open_topography(spec), spec)
        return surface.heights(), surface, surface.prepared

    return call


def test_detrended(prepared):
    z = random_heights(N)
    for kind, trend in (("mean", 5.0), ("tilt", PLANE), ("curvature", BOWL)):
        bare, with_trend = (prepared(heights, detrend=kind)[0] for heights in (z, z + trend))
        assert np.allclose(with_trend, bare, atol=1e-11)
        assert np.allclose(prepared(bare, detrend=kind)[0], bare, atol=1e-12)
        assert abs(bare.mean()) < 1e-13
    left = prepared(z, detrend="tilt")[0]
    assert abs(np.sum(left * (X - X.mean()))) + abs(np.sum(left * (Y - Y.mean()))) < 1e-11


def test_holes(prepared):
    """Those that are filled are in test_scans.py."""
    holes = PLANE.copy()
    holes[2:5, 3:9] = np.nan
    heights, _, steps_done = prepared(holes, fill="harmonic", detrend="tilt")
    assert np.allclose(heights, 0, atol=1e-12)  # the trend is that of the measured points
    assert "18 points (13 %) filled" in steps_done
    with pytest.raises(SceneError, match=r"found nan at \(2, 3\) in .*, 18 points without"):
        prepared(holes)
    with pytest.raises(SceneError, match="where some are known"):
        prepared(np.full(N, np.nan), fill="harmonic")


def test_cropped_flipped_mirrored(prepared):
    z = random_heights(N)
    heights, topography, steps_done = prepared(z, crop=(2 / 7, 0.2, 10 / 7, 0.9))
    assert np.array_equal(heights, z[2:10, 2:9])
    assert topography.sizes == pytest.approx((8 / 7, 0.7))
    assert steps_done == ("cropped to 8 x 7 points",)
    assert np.array_equal(prepared(z, flip=True)[0], -z)
    heights, topography, _ = prepared(z + PLANE, boundary="mirror")
    assert topography.sizes == (4.0, 2.0)
    assert np.array_equal(heights[:14, :10], z + PLANE)
    assert np.array_equal(heights, heights[::-1])
    assert np.array_equal(heights, heights[:, ::-1])
    for axis, boundary in enumerate((["mirror", "free"], ["periodic", "mirror"])):
        along_axis, topography, steps_done = prepared(z, boundary=boundary)
        assert steps_done == (f"mirrored along {'xy'[axis]}",)
        assert topography.sizes[axis] == 2 * SIZES[axis]
        assert np.array_equal(along_axis, np.concatenate([z, np.flip(z, axis)], axis))
    for crop in ((0, 0, 3, 1), (1, 0, 1, 1)):
        with pytest.raises(
            SceneError, match=r"surface.crop: found points \d+ to \d+ of 14 along x.*x1 <= 2 and"
        ):
            prepared(z, crop=crop)


def test_window(prepared):
    z = random_heights(N) + PLANE
    heights, _, steps_done = prepared(z, window="hann")
    assert steps_done == ("mean removed", "window hann")
    assert np.allclose(
        heights,
        (z - z.mean()) * np.outer(*(0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n) for n in N)),
    )


def test_resampled(prepared):
    """A Fourier series is the same on any grid that resolves it, and loses its short waves on a
    coarser one."""

    def series(n, short):
        x, y = np.meshgrid(*(2 * np.pi * np.arange(k) / k for k in n), indexing="ij")
        return 1 + np.cos(2 * x - y) + np.sin(x) * np.cos(2 * y) + short * np.cos(5 * x)

    def cosines(n):
        """Return cosines that continue smoothly in their mirror images (free edges)."""
        x, y = (np.pi * (np.arange(k) + 0.5) / k for k in n)
        return np.cos(3 * x)[:, None] * np.cos(y) + np.cos(5 * x)[:, None]

    fine, topography, steps_done = prepared(series(N, 1), refine=3)
    assert np.allclose(fine, series((42, 30), 1))
    assert topography.sizes == SIZES
    assert steps_done == ("resampled to 42 x 30 points",)
    assert np.allclose(prepared(series(N, 1), downsample=2)[0], series((7, 5), 0))
    free = prepared(cosines(N), refine=6, downsample=2, boundary="free")[0]
    assert np.allclose(free, cosines((42, 30)))
    assert np.allclose(prepared(series(N, 1), refine=3, downsample=2)[0], series((21, 15), 1))
    with pytest.raises(
        SceneError, match=r"surface.downsample: found 4, allowed: a divisor of 14 and of 10"
    ):
        prepared(series(N, 0), downsample=4)
