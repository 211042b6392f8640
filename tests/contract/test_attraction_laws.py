"""The contract of laws of attraction; new files in hpc_gfmd/laws are tested automatically."""

import numpy as np
import pytest

from hpc_gfmd import laws
from hpc_gfmd.kernels.attraction import curvature_at, energy_at, traction_at
from hpc_gfmd.kernels.jit import kernel
from hpc_gfmd.laws.base import Law, gaps_of, in_precision, is_concave, scaled, steepest
from hpc_gfmd.util.errors import SceneError

WORK = 3.0
RANGE = 0.25
every_law = pytest.mark.parametrize("name", laws.law_names())


@kernel
def of_each_point(law, g, energy, traction, curvature):
    for i in range(g.shape[0]):
        energy[i] = energy_at(law, g[i])
        traction[i] = traction_at(law, g[i])
        curvature[i] = curvature_at(law, g[i])


def made(name):
    return laws.law_named(name, WORK, RANGE)


@every_law
def test_energy_in_contact_and_far_away(name):
    law = made(name)
    assert law.energy(0.0) == pytest.approx(-WORK)
    assert law.energy(100 * RANGE) == pytest.approx(0, abs=1e-4 * WORK)
    assert law.traction(100 * RANGE) == pytest.approx(0, abs=1e-4 * WORK / RANGE)


@every_law
def test_attraction_pulls_and_falls_with_the_gap(name):
    law = made(name)
    g = gaps_of(law)
    traction = law.traction(g)
    assert traction.min() >= 0
    assert np.diff(traction).max() <= 1e-12 * traction.max()
    assert law.curvature(g).max() <= 0
    assert is_concave(law)
    assert steepest(law) == pytest.approx(np.abs(law.curvature(g)).max())


@pytest.mark.parametrize("wrong", ["traction", "curvature"])
def test_a_law_that_attracts_more_farther_away_is_refused(wrong):
    """Also where only one of its functions says so."""
    law = made("exponential")
    rises = {"traction": lambda g: g, "curvature": np.ones_like}[wrong]
    kind = type("Rising", (type(law),), {wrong: staticmethod(rises)})
    assert not is_concave(kind(WORK, RANGE))


@every_law
def test_derivatives_agree(name):
    """Integrals of derivatives are compared, since the curvature may jump; a jump within an
    interval is an error of half of it."""
    law = made(name)
    g = np.linspace(0, 12 * RANGE, 400_001)
    for function, derivative in ((law.energy, law.traction), (law.traction, law.curvature)):
        middle = derivative((g[1:] + g[:-1]) / 2)
        integral = np.cumsum(middle) * (g[1] - g[0])
        jump = np.abs(middle).max() * (g[1] - g[0])
        error = np.abs(function(g)[1:] - function(0.0) - integral).max()
        assert error < 1e-5 * abs(function(0.0)) + jump


@every_law
def test_range_is_the_length_scale(name):
    """At least half of the work is done within one range, and 95 % within three."""
    law = made(name)
    assert -law.energy(3 * RANGE) < 0.05 * WORK
    assert -law.energy(RANGE) < 0.5 * WORK


@every_law
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float32, 2e-5), (np.float64, 1e-12)])
def test_kernels_agree_with_numpy(name, dtype, tolerance):
    law = made(name)
    g = np.linspace(0, 30 * RANGE, 5001).astype(dtype)
    in_kernel = [np.empty_like(g) for _ in range(3)]
    of_each_point(in_precision(law, np.dtype(dtype)), g, *in_kernel)
    exact = g.astype(float)
    for values, function in zip(in_kernel, (law.energy, law.traction, law.curvature), strict=True):
        exact_values = function(exact)
        jumps = np.abs(np.abs(exact / RANGE - 1) - 0.1) < 1e-5  # of the ramp's curvature
        errors = np.abs(values - exact_values)[~jumps]
        assert (errors <= tolerance * np.abs(exact_values[~jumps]) + 1e-6 * tolerance * WORK).all()


@every_law
def test_scaling_to_other_units(name):
    """A law in other units has the same energies and tractions."""
    in_si = made(name)
    in_other_units = scaled(made(name), 5.0, 0.1)
    g = gaps_of(in_si)
    assert np.allclose(in_other_units.traction(g / 0.1) * 5.0, in_si.traction(g))
    assert np.allclose(in_other_units.energy(g / 0.1) * 5.0 * 0.1, in_si.energy(g))


class Bump(Law):
    name = "bump"

    def energy(self, g):
        return -self.work * np.exp(-((g / self.range) ** 2))

    def traction(self, g):
        return -2 * g / self.range**2 * self.energy(g)

    def curvature(self, g):
        return (-2 / self.range**2 + (2 * g / self.range**2) ** 2) * self.energy(g)


def test_a_law_that_is_not_concave_is_refused(monkeypatch):
    monkeypatch.setattr(laws, "law_class", lambda name: Bump)
    with pytest.raises(SceneError, match=r'material.adhesion.law: .*"bump".*concave') as refusal:
        laws.law_named("bump", WORK, RANGE)
    assert "\n" not in str(refusal.value)
