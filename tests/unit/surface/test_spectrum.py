"""Walls with a given spectrum: their power, units, conversions, and tables that are refused."""

import re

import numpy as np
import pytest
from contacts import rough, wave_numbers
from refusal import refused

import hpc_gfmd
from hpc_gfmd.surface import directional_spectrum
from hpc_gfmd.surface.spectra import Spectrum, of_isotropic_surface
from hpc_gfmd.util.errors import SceneError

Q = 2 * np.pi * np.array([1.0, 3.0, 20.0])  # of a cell of length 1
C = np.array([2e-4, 2e-4, 1e-8])
ARRAYS = {"q": Q, "C": C, "dimension": 2}


def wall(n=(64, 64), **keys):
    return hpc_gfmd.make_surface("spectrum", **{"n": n, "seed": 1} | keys)


def power_of(surface):
    """(|q|, L_x L_y |h_q|^2) of all modes of a surface, as arrays of its shape."""
    z = surface.heights
    q = wave_numbers(z.shape, surface.sizes)
    return q, np.prod(surface.sizes) * np.abs(np.fft.fft2(z) / z.size) ** 2


@pytest.mark.parametrize(("random", "variance"), [("amplitudes", 0.4), ("phases", 0.0)])
def test_power_agrees_with_the_table(random, variance):
    """Chi-square of rings over 50 seeds: |h_q|^2 of uniform parts has the variance 2/5."""
    ratios = 0.0
    for seed in range(50):
        q, power = power_of(wall(**ARRAYS, seed=seed, random=random))
        inside = (q >= Q[0] * (1 - 1e-9)) & (q <= Q[-1] * (1 + 1e-9))
        assert power[~inside & (q > 0)].max() < 1e-25
        ratios = ratios + power[inside] / Spectrum(Q, C).at(np.clip(q[inside], Q[0], Q[-1]))
    ring = (q[inside] / (2 * np.pi) + 0.5).astype(int)
    number = np.bincount(ring)[1:] / 2  # independent modes, of which each comes twice
    means = np.bincount(ring, ratios / 50)[1:] / (2 * number)
    if not variance:
        assert means == pytest.approx(1, rel=1e-12)
        return
    chi_square = np.sum((means - 1) ** 2 * 50 * number / variance)
    assert abs(chi_square - len(means)) < 3 * np.sqrt(2 * len(means))


@pytest.mark.parametrize("lam_l_over_lam_r", [1.0, 2.0])
def test_self_affine_wall_from_power_laws(lam_l_over_lam_r):
    """Also with waves of two points; a table with absolute C differs by a factor alone."""
    keys = rough((2, 8, 2), seed=3, lam_l_over_lam_r=lam_l_over_lam_r, physical_sizes=(2.0, 1.0))
    made = hpc_gfmd.make_surface(**keys)
    hurst = [-1.0, keys["hurst"]]
    lengths = [1.0, 1 / lam_l_over_lam_r, 1 / 8]
    if lam_l_over_lam_r == 1:
        hurst = hurst[1:]
        lengths = lengths[1:]
    cell = {"n": made.heights.shape, "seed": 3, "physical_sizes": (2.0, 1.0)}
    laws = wall(wavelengths=lengths, hurst=hurst, g_rms=keys.get("g_rms", 1.0), **cell)
    rounding = 1e-14 * np.abs(made.heights).max()
    assert laws.heights == pytest.approx(made.heights, abs=rounding)
    q = 2 * np.pi / np.array(lengths)
    falls = np.cumsum((2 + 2 * np.array(hurst)) * np.diff(np.log(q)))
    table = wall(q=q, C=1e-3 * np.exp(-np.append(0, falls)), dimension=2, **cell)
    scaled = table.heights * (made.h_rms / table.h_rms)
    assert scaled == pytest.approx(made.heights, abs=10 * rounding)


def test_a_table_of_profiles_gives_that_of_the_surface():
    """C1(q) = (1/pi) integral of C q'/sqrt(q'^2 - q^2) dq', which is c/(4 q^3) for C = c/q^4."""
    q = np.geomspace(1, 100, 30)
    C1 = 3.0 / (4 * q**3)
    assert of_isotropic_surface(Spectrum(q, C1)).C == pytest.approx(3.0 / q**4, rel=1e-12)


def test_profiles_of_the_wall_have_the_spectrum_of_the_table():
    """With a knee, and rows so dense that power laws between them are exact."""
    q = 2 * np.pi * np.geomspace(1, 60, 200)
    C1 = 1e-5 / (1 + (q / 60) ** 2) ** 1.5
    keys = {"q": q, "C": C1, "dimension": 1, "n": (128, 128)}
    power = 0.0
    for seed in range(20):
        z = wall(**keys, seed=seed, random="phases").heights
        power = power + np.mean(np.abs(np.fft.fft(z, axis=0) / 128) ** 2, axis=1) / 20
    k = np.arange(2, 12)  # further on the waves beyond the table lack
    assert power[k] == pytest.approx(np.interp(2 * np.pi * k, q, C1), rel=0.08)


def test_units_of_a_table(tmp_path):
    """q in 1/um and C in nm^4, as the head says; a row q = 0 and further columns do not count."""
    rows = "\n".join(f"{q},{C * 1e12},7" for q, C in zip(Q, C))
    path = tmp_path / "spectrum.csv"
    path.write_text(f"# measured on Monday\nq [µm⁻¹], C (nm^4), bar\n0,5,5\n{rows}\n")
    named = wall(path=str(path), physical_sizes=("1 um", "1 um"))
    assert named.heights == pytest.approx(1e-6 * wall(**ARRAYS).heights, rel=1e-9, abs=1e-20)
    assert named.unit == "m"
    assert "of the surface" in named.prepared[0]


@pytest.mark.parametrize("between", [";", "\t", " ; ", "  "])
def test_decimal_commas_of_a_table(tmp_path, between):
    """They were parted into whole numbers, silently where no q was below 1."""
    rows = "\n".join(f"{q}{between}{C}{between}7,5" for q, C in zip(Q, C)).replace(".", ",")
    path = tmp_path / "spectrum.csv"
    path.write_text(f"q (1/nm){between}C (nm^4)\n{rows}\n")
    named = wall(path=str(path), physical_sizes=("1 nm", "1 nm"))
    assert named.heights == pytest.approx(1e-9 * wall(**ARRAYS).heights, rel=1e-9, abs=1e-20)


def test_anisotropic_wall_has_the_moments_of_its_stretch():
    """Mean squares of slopes along and across the lay are those of C over 2 g and g/2."""
    peklenik = 3.0
    angle = 30.0
    rows = {"q": 2 * np.pi * np.array([5.0, 60.0]), "C": [1e-4, 1e-8], "dimension": 2}
    made = wall((256, 256), **rows, random="phases", peklenik=peklenik, angle=angle)
    power = np.abs(np.fft.fft2(made.heights) / made.heights.size) ** 2
    k = 2 * np.pi * np.fft.fftfreq(256, 1 / 256)
    q = np.stack(np.meshgrid(k, k, indexing="ij"))
    moments = np.einsum("aij,bij,ij->ab", q, q, power)
    c = np.cos(np.radians(angle))
    s = np.sin(np.radians(angle))
    turned = np.array([[c, s], [-s, c]]) @ moments @ np.array([[c, s], [-s, c]]).T
    isotropic = Spectrum(rows["q"], np.array(rows["C"])).roughness().g_rms ** 2 / 2
    assert np.diag(turned) / isotropic == pytest.approx([1 / peklenik, peklenik], rel=0.01)
    assert abs(turned[0, 1]) < 0.01 * isotropic


LAWS = {"wavelengths": [0.5, 0.1], "hurst": [0.8], "g_rms": 1.0}


NO_SPECTRUM = [
    (LAWS | {"hurst": [0.8, 0.3]}, "found 2 numbers hurst for 2 wavelengths"),
    (LAWS | {"wavelengths": [0.1, 0.5]}, "found wavelengths that do not fall"),
    (LAWS | {"wavelengths": [0.5, 0.01]}, "waves with 100 periods along x on 64 points"),
    (LAWS | ARRAYS, "found q and wavelengths, allowed: one of path, q, wavelengths"),
    (LAWS | {"skewness": -1.0, "kurtosis": 1.5}, "allowed: kurtosis above"),
    (ARRAYS | {"h_rms": 1.0, "g_rms": 1.0}, "found h_rms and g_rms"),
    (ARRAYS | {"physical_sizes": ("1 um", "1 um")}, "surface.q: found no unit of q and C"),
]


def test_keys_that_are_no_spectrum_are_refused():
    for keys, words in NO_SPECTRUM:
        with pytest.raises(SceneError, match=words):
            wall(**keys)


def test_spectrum_of_both_wave_numbers(tmp_path):
    """Waves of random phases have the power of the table, also oblique ones."""
    k = np.arange(-12, 13)
    q = 2 * np.pi * k / 1e-6
    C = np.exp(-((k[:, None] - k[12:]) ** 2) / 20.0) * (np.hypot(k[:, None], k[12:]) > 2)
    np.savez(tmp_path / "C.npz", q_x=q * 1e-9, q_y=q[12:] * 1e-9, C=C)
    keys = {"path": str(tmp_path / "C.npz"), "unit": "nm", "physical_sizes": ("1 um", "1 um")}
    made = wall((32, 40), **keys, random="phases")
    _, power = power_of(made)
    assert power[k[:, None], k[12:]][C > 0] == pytest.approx(1e-36 * C[C > 0], rel=1e-9)
    assert power.sum() == pytest.approx(1e-36 * (2 * C[:, 1:].sum() + C[:, 0].sum()), rel=1e-9)
    coarse = {"rel": 0, "abs": 1e-12 * made.h_rms}
    fine = wall((64, 40), **keys, random="phases").heights[::2]
    assert fine - fine.mean() == pytest.approx(made.heights - made.heights.mean(), **coarse)
    with pytest.raises(SceneError, match="12 periods along x on 16 points"):
        wall((16, 40), **keys)


def test_the_shortest_waves_of_a_table_on_the_coarsest_grid(tmp_path):
    """A grid that sees one part of them alone, along x and along y, has the heights' rms of any."""
    k = np.arange(-8, 9)
    C = (np.hypot(k[:, None], k[8:]) <= 8) * 1e-4
    np.savez(tmp_path / "C.npz", q_x=2 * np.pi * k, q_y=2 * np.pi * k[8:], C=C)
    for random in ("amplitudes", "phases"):
        keys = {"path": str(tmp_path / "C.npz"), "random": random}
        coarse, fine = (wall((n, n), **keys).heights for n in (16, 32))
        assert coarse.std() == pytest.approx(fine.std(), rel=1e-9)


BAD_ARRAYS = [
    ({"q_y": [-1.0, 1.0]}, "found q_y = -1"),
    ({"C": np.ones((3, 2))}, r"found C of shape \(3, 2\)"),
    ({"C": -np.ones((2, 2))}, "found C = -1"),
    ({"q_x": [1.0, 1.0]}, "q_x that do not rise"),
]


def test_bad_arrays_are_refused(tmp_path):
    for change, words in BAD_ARRAYS:
        arrays = {"q_x": [-7.0, 7.0], "q_y": [0.0, 7.0], "C": np.ones((2, 2))}
        np.savez(tmp_path / "C.npz", **arrays | change)
        with pytest.raises(SceneError, match=words):
            wall(path=str(tmp_path / "C.npz"))


def test_arrays_without_numbers_are_refused_and_mistakes_are_not(tmp_path, monkeypatch):
    path = str(tmp_path / "C.npz")
    np.savez(path, q_x=np.zeros(2, "f8, U3"), q_y=[0.0, 7.0], C=np.ones((2, 2)))
    with pytest.raises(SceneError, match=r"cannot read .*: Cannot cast array data"):
        wall(path=path)
    monkeypatch.setattr(directional_spectrum, "np", None)
    with pytest.raises(AttributeError):
        directional_spectrum.read_directional(path)


def moments(z):
    x = (z - z.mean()) / z.std()
    return np.mean(x**3), np.mean(x**4)


@pytest.mark.parametrize("wanted", [(-1.0, 5.0), (0.5, 2.4)])
def test_heights_that_are_not_gaussian(wanted):
    """The power of each wave is that without them; skewness and kurtosis are those asked for."""
    gaussian = wall((128, 128), **ARRAYS)
    made = wall((128, 128), **ARRAYS, skewness=wanted[0], kurtosis=wanted[1])
    assert moments(made.heights) == pytest.approx(wanted, abs=0.15)
    powers = [power_of(surface)[1][power_of(surface)[0] > 0] for surface in (gaussian, made)]
    assert powers[1] == pytest.approx(powers[0], rel=1e-9, abs=1e-18)
    assert "the spectrum holds" in made.prepared[-1]


def test_heights_distributed_as_a_sample(tmp_path):
    sample = np.random.default_rng(0).gamma(3.0, size=5000)
    np.save(tmp_path / "sample.npy", sample)
    made = wall((64, 64), **ARRAYS, heights=str(tmp_path / "sample.npy"))
    shares = np.linspace(0.02, 0.98, 50)
    quantiles = np.quantile((made.heights - made.heights.mean()) / made.h_rms, shares)
    assert quantiles == pytest.approx(
        np.quantile((sample - sample.mean()) / sample.std(), shares), abs=0.1
    )


BAD_TABLES = [
    ("q (1/um), C (um^4)\n1,2\n2,-1\n", "surface.path: found C = -1 in row 2 of"),
    ("q (1/um), C (um^4)\n2,2\n1,1\n", "found q = 2 and then 1 in row 2"),
    ("q, C\n1,2\n2,1\n", "surface.dimension: not given"),
    ("q (1/length), C (length^4)\n1,2\n2,1\n", "surface.path: found no unit of q and C"),
    ("q (1/um), C (um^4)\n1,2\n9999,1\n", "up to 9.999e+09 1/m, waves with 15913.9 periods"),
    ("q (1/um), C (um^4)\n1,2\n", "found 1 rows"),
    ("q (1/um), C (um^4)\n1,2\n2\n", "found '2' in line 3"),
    ("q (1/um), C1D (um^3)\n1,1\n2,2\n3,1\n", "profiles that rises between"),
    ("q (1/um), C (um^4)\n0.1,2\n0.2,1\n", "found no wave of the cell"),
    ("", "found no numbers"),
]


def test_bad_tables_are_refused_in_one_line(tmp_path):
    path = tmp_path / "spectrum.csv"
    for text, words in BAD_TABLES:
        path.write_text(text)
        with refused(re.escape(words)):
            wall(path=str(path), physical_sizes=("10 um", "10 um"))
