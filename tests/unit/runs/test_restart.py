"""A run that was stopped, or died, and went on is the run that was not disturbed, to the last
bit."""

from dataclasses import replace

import numpy as np
import pytest
from pieces import Pieces, scene

from hpc_gfmd.driver import start
from hpc_gfmd.operators import deflation as gapmode
from hpc_gfmd.output.read import read_result
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.solvers import solver_names


@pytest.fixture
def pieces(monkeypatch, tmp_path):
    return Pieces(monkeypatch, SerialComm(), tmp_path)


@pytest.mark.parametrize("solver", sorted(solver_names()))
def test_bit_identical(pieces, solver):
    """Stopped in the middle of loads and at once, and dead somewhere without a word, with and
    without checkpoints."""
    asked = scene(solver)
    count = pieces.undisturbed(asked)
    part = count // 4
    for plan in (
        [
            (1, False, ()),
            (1, False, ()),
            (part, False, ()),
            (part, False, ()),
            (part + 1, False, ()),
        ],
        [(count - 2, True, ())],
        [(2 * part, True, (part,)), (part, True, (2, 3))],
    ):
        pieces.run(asked, *plan)
        pieces.compare()


SWEEPS = {
    "each load": scene("auto"),
    "full contact that ends": scene(
        "auto", {"gap_over_h_rms": [1e-5, 0, 0.1]}, boundary=["free", "periodic"]
    ),
    "low memory": scene("bpx", [0.05, 0.06, 0.3], ["gap"], low_memory=True),
    "prescribed": scene("auto", {"gap_over_h_rms": [0.3, 0.32, 1.2, 0.0, 0.4]}),
    "prescribed areas": scene("bpx", {"a_r": [0.1, 0.5]}, ["gap"], low_memory=True),
    "single until a load with few points": scene(
        "auto", [0.3, 1e-4, 1.2e-4, 1.3e-4], precision="auto", accuracy=1e-3
    ),
}


@pytest.mark.parametrize("name", SWEEPS)
def test_wherever_it_is_stopped(pieces, name):
    stop_everywhere(pieces, SWEEPS[name], rel=1e-8 if name == "full contact that ends" else 0)


def test_with_a_gap_mode(pieces, monkeypatch):
    """Which small grids have none of."""
    monkeypatch.setattr(gapmode, "CALIBRATION", replace(gapmode.CALIBRATION, fewest=1))
    stop_everywhere(pieces, scene("bpx", [0.01, 0.012, 0.05]))


def test_precision_given_up_in_the_middle(pieces, monkeypatch):
    """A load that stagnates in single precision is solved again in double; stopped there, it does
    not begin in single again."""
    monkeypatch.setattr(start, "first_precision", lambda _: np.dtype(np.float32))
    asked = scene("bpx", [0.3, 0.35], precision="auto", accuracy=None, residual=1e-8)
    stop_everywhere(pieces, asked)
    assert read_result(pieces.whole).steps[0]["fft_pairs"] > 40  # of both attempts


def stop_everywhere(pieces, asked, rel=0):
    """Or at least in five places."""
    count = pieces.undisturbed(asked)
    for point in range(1, count, max(1, count // 5)):
        pieces.run(asked, (point, False, ()))
        pieces.compare(rel)
