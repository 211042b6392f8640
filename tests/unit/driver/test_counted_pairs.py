"""The FFT pairs of a load against the transforms that are made."""

import pytest
from contacts import Pressing, rough, sweep_of

from hpc_gfmd.driver.load import Load
from hpc_gfmd.parallel.fft import SlabFFT

ROUNDED_UP = 1.03  # coarse grids are charged whole pairs


@pytest.fixture
def transformed(monkeypatch):
    """[points transformed so far, there and back being twice half of them]"""
    points = [0.0]
    columns = SlabFFT.columns
    multiply_columns = SlabFFT.multiply_columns

    def counted_columns(fft, apply, forward=True, backward=True):
        points[0] += (forward + backward) / 2 / fft.scale
        return columns(fft, apply, forward, backward)

    def counted_multiply(fft, factors, inverse, backward):
        points[0] += (1 + backward) / 2 / fft.scale
        return multiply_columns(fft, factors, inverse, backward)

    monkeypatch.setattr(SlabFFT, "columns", counted_columns)
    monkeypatch.setattr(SlabFFT, "multiply_columns", counted_multiply)
    return points


@pytest.mark.parametrize(
    ("settings", "loads"),
    [
        ({"accuracy": 1e-2}, [0.05, 0.06, 0.02]),
        ({"accuracy": 1e-5}, [0.05, 0.06]),
        ({"accuracy": 1e-2, "nested": False}, [0.05, 0.02]),
        ({"accuracy": 1e-2}, [Load("a_r", 0.1)]),
        # first pressures and certificates in double precision
        ({"accuracy": 3e-5, "precision": "single"}, [0.05, 0.06]),
        ({"accuracy": 1e-2, "name": "gfmd"}, [0.05, 0.06]),
        # coarse grids find that it needs double precision
        ({"accuracy": 1e-2}, [Load("gap_mean", 0.0316)]),
    ],
)
def test_every_transform_is_counted(settings, loads, transformed):
    """All but those that make the surface."""
    sweep = sweep_of(rough((2, 32, 2)), **settings).sweep
    make_surface = sweep.make_surface

    def not_counted(precision):
        before = transformed[0]
        surface = make_surface(precision)
        transformed[0] = before
        return surface

    sweep.make_surface = not_counted
    for load in loads:
        transformed[0] = 0.0
        pairs = Pressing(sweep).solve(load).fft_pairs
        made = transformed[0] / sweep.surface.grid.N
        assert made <= pairs <= made * ROUNDED_UP
