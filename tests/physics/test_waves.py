"""The sinusoidal contacts of Westergaard and of Johnson, Greenwood and Higginson, and the order of
convergence."""

from math import pi, sqrt

import numpy as np
import pytest
from contacts import EXACT, field, order, sweep_of

from hpc_gfmd.contact import all_observables
from hpc_gfmd.theory.elastic import Westergaard

A = 0.05


def wave(n, periods=(1, 0)):
    return {
        "kind": "wave",
        "amplitude": A,
        "n": [n, 4] if periods == (1, 0) else [n, n],
        "periods": list(periods),
    }


def solve_wave(n, p_hat, p_full, periods=(1, 0)):
    """Return a_r, gap_mean, energy and peak_pressure at p_hat = p/p_full."""
    step = sweep_of(wave(n, periods), **EXACT).solve(p_hat * p_full)
    assert step.status == "converged"
    values = {name: all_observables()[name](step) for name in ("a_r", "gap_mean", "energy")}
    return values | {"peak_pressure": field(step, "pressure").max()}


@pytest.mark.parametrize("p_hat", [0.05, 0.2, 0.5, 0.8])
def test_westergaard(p_hat):
    exact = Westergaard(p_hat * pi * A, A)
    values = solve_wave(1024, p_hat, pi * A)
    assert values.pop("a_r") == pytest.approx(exact.a_r, abs=2.5 / 1024)  # whole pixels
    for name, value in values.items():
        assert value == pytest.approx(getattr(exact, name), rel=2e-4), name


def test_westergaard_converges():
    """The area converges with first order (pixels), mean gap and energy with second order."""
    ns = [32, 64, 128, 256]
    loads = np.linspace(0.1, 0.8, 17)
    errors = {"a_r": [], "gap_mean": [], "energy": []}
    for n in ns:
        squares = {name: [] for name in errors}
        for p_hat in loads:  # an average, because the contact ends at random within a pixel
            values = solve_wave(n, p_hat, pi * A)
            exact = Westergaard(p_hat * pi * A, A)
            for name in errors:
                squares[name].append((values[name] / getattr(exact, name) - 1) ** 2)
        for name in errors:
            errors[name].append(np.sqrt(np.mean(squares[name])))
    slopes = {name: order(ns, e) for name, e in errors.items()}
    assert 0.8 < slopes["a_r"] < 1.5, slopes
    assert slopes["gap_mean"] > 1.6, slopes
    assert slopes["energy"] > 1.6, slopes


def test_johnson_at_small_load():
    """a_r -> pi (3 p_hat/8 pi)^(2/3), Hertz's contact at every peak."""
    ratios = [
        solve_wave(512, p_hat, sqrt(2) * pi * A, (1, 1))["a_r"]
        / (pi * (3 * p_hat / (8 * pi)) ** (2 / 3))
        for p_hat in (0.016, 0.004)
    ]
    assert ratios[1] == pytest.approx(1, abs=0.03)
    assert 0 < ratios[1] - 1 < ratios[0] - 1


def test_johnson_near_full_contact():
    """1 - a_r -> 3/(2 pi) (1 - p_hat)."""
    for p_hat, tolerance in ((0.9, 0.06), (0.97, 0.03)):
        values = solve_wave(512, p_hat, sqrt(2) * pi * A, (1, 1))
        assert (1 - values["a_r"]) / (3 / (2 * pi) * (1 - p_hat)) == pytest.approx(1, abs=tolerance)
