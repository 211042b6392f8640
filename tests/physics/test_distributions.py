"""Histograms, spectra and autocorrelations against NumPy on the whole field."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import rough, solve_scene, wave_numbers
from counted import contact_of, random_fields

import hpc_gfmd
from hpc_gfmd.contact import all_distributions

N = (48, 40)
SIZES = (1.2, 1.5)
UNITS = (3.0, 0.2)  # of pressure and of gap
every_field = pytest.mark.parametrize("name", ["heights", "pressure", "gap"])


@pytest.fixture(scope="module")
def made():
    """A contact and its fields in the units of the scene."""
    g, q = random_fields(N)
    h = np.random.default_rng(5).random(N)
    fields = {"heights": -h * UNITS[1], "pressure": q * UNITS[0], "gap": g * UNITS[1]}
    return contact_of(g, q, SIZES, h=h, units=UNITS), fields


@pytest.mark.parametrize("name", ["pressure", "gap"])
def test_histograms(made, name):
    contact, fields = made
    edges, density = all_distributions()[name](contact).values()
    values = fields[name][fields[name] > 0]
    counts = np.histogram(values, edges)[0]
    assert counts.sum() == len(values)
    assert density == pytest.approx(counts / len(values) / np.diff(edges))
    assert density[0] > 0
    assert density[-1] > 0
    assert np.sum(density * np.diff(edges)) == pytest.approx(1)


def test_narrow_and_empty():
    """In full contact the bins begin near the lowest pressure; an empty histogram is None."""
    q = 10 + 0.01 * np.random.default_rng(1).random((20, 30))
    full = contact_of(np.zeros((20, 30)), q)
    edges = all_distributions()["pressure"](full)["edges"]
    assert 9.99 < edges[0] < edges[-1] < 10.02
    assert all_distributions()["gap"](full) is None
    assert len(all_distributions()["pressure"](contact_of(np.zeros((2, 3))))["density"]) == 1
    open_ = contact_of(np.ones((20, 30)))
    assert all_distributions()["pressure"](open_) is all_distributions()["patches"](open_) is None


def test_histograms_of_an_unconverged_contact():
    """Dents under tension count as gaps of 0; nan does not count."""
    g = np.array([[0.0, np.nan], [-1.0, 1.0]])
    p = np.array([[1.0, 0.0], [-1.0, 0.0]])
    edges, density = all_distributions()["gap"](replace(contact_of(g, p), hardness=2.0)).values()
    shares = density * np.diff(edges)
    assert edges[0] == 0
    assert shares[[0, -1]] == pytest.approx([0.5, 0.5])


def rings(distance, values, smallest):
    """Return the means of distance and values over rings, eight in a factor of two."""
    distance = distance.ravel()
    values = values.ravel()
    octaves = np.log2(np.maximum(distance, 1e-300) / smallest)
    number = np.where(distance > 0, np.round(8 * octaves), -1)
    filled = np.unique(number)
    return [np.array([x[number == k].mean() for k in filled]) for x in (distance, values)]


@every_field
def test_power_spectrum(made, name):
    contact, fields = made
    q = wave_numbers(N, SIZES)
    C = np.abs(np.fft.fft2(fields[name]) / np.prod(N)) ** 2 * np.prod(SIZES)
    expected = rings(q[q > 0], C[q > 0], 2 * np.pi / max(SIZES))
    spectrum = all_distributions()[f"{name}_spectrum"](contact)
    assert spectrum["q"] == pytest.approx(expected[0], rel=1e-12)
    assert spectrum["power"] == pytest.approx(expected[1], rel=1e-9)


@every_field
def test_autocorrelation(made, name):
    contact, fields = made
    f = fields[name] - fields[name].mean()
    A = np.fft.ifft2(np.abs(np.fft.fft2(f)) ** 2).real / np.prod(N)
    x, y = (
        np.minimum(np.arange(n), n - np.arange(n)) * L / n for n, L in zip(N, SIZES, strict=True)
    )
    r = np.hypot(x[:, None], y)
    near = r <= min(SIZES) / 2
    expected = rings(r[near], A[near], min(L / n for n, L in zip(N, SIZES, strict=True)))
    autocorrelation = all_distributions()[f"{name}_autocorrelation"](contact)
    assert autocorrelation["r"] == pytest.approx(expected[0], rel=1e-12)
    assert autocorrelation["correlation"] == pytest.approx(expected[1], abs=1e-12 * A.max())
    assert autocorrelation["correlation"][0] == pytest.approx(fields[name].var())


def test_a_profile_has_the_spectrum_of_a_line():
    """The power of a wave is in one ring, and its autocorrelation is the cosine."""
    x = np.arange(64) / 64
    z = np.repeat(0.01 * np.cos(2 * np.pi * 4 * x)[:, None], 8, axis=1)
    L_x, L_y = 2.0, 3.0
    distributions = hpc_gfmd.solve(
        z,
        0.01,
        physical_sizes=(L_x, L_y),
        distributions=["heights_spectrum", "heights_autocorrelation"],
    ).distributions
    q, power = distributions["heights_spectrum"].values()
    ring = np.argmin(np.abs(q - 8 * np.pi / L_x))
    # for each sign of q; as of any other surface the variance is the sum over q over the area
    assert power[ring] == pytest.approx(L_x * L_y * 0.01**2 / 4)
    assert np.delete(power, ring) == pytest.approx(0, abs=1e-12)
    r, correlation = distributions["heights_autocorrelation"].values()
    single = r <= 4 * L_x / 64  # rings of one distance
    assert correlation[single] == pytest.approx(0.01**2 / 2 * np.cos(8 * np.pi * r[single] / L_x))


def test_the_spectrum_of_heights_in_low_memory():
    low_memory, plain = (
        all_distributions()["heights_spectrum"](
            solve_scene(rough((1, 16, 4)), 0.1, accuracy=1e-2, low_memory=low)
        )
        for low in (True, False)
    )
    inside = plain["power"] > 1e-9 * plain["power"].max()
    assert low_memory["q"] == pytest.approx(plain["q"])
    assert low_memory["power"][inside] == pytest.approx(plain["power"][inside], rel=1e-4)
