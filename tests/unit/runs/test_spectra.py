"""Spectra of surfaces: the table of which a wall was made comes back, and goes to finer waves."""

from types import SimpleNamespace

import numpy as np
import pytest

import hpc_gfmd
from hpc_gfmd.util.errors import SceneError
from hpc_gfmd.util.libraries import surface_topography

Topography = surface_topography().Topography

SIZES = ("100 um", "100 um")
LAWS = {"wavelengths": ["100 um", "20 um", "1 um"], "hurst": [-1.0, 0.8], "g_rms": 0.1}
Q = 2 * np.pi / np.array([10e-6, 5e-6, 2e-6])


@pytest.fixture(scope="module")
def wall():
    keys = {"n": (256, 256), "seed": 1, "physical_sizes": SIZES, "random": "phases"}
    return hpc_gfmd.make_surface("spectrum", **LAWS, **keys)


def law(q):
    """Ratio of C to that at the first q."""
    return (q / q[0]) ** -3.6


def test_spectrum_of_a_wall_is_its_table(wall, tmp_path):
    spectrum = hpc_gfmd.spectrum_of(wall, per_decade=20)
    assert spectrum.at(Q) / spectrum.at(Q[0]) == pytest.approx(law(Q), rel=0.05)
    assert spectrum.roughness().g_rms == pytest.approx(0.1, rel=0.02)
    spectrum.write(tmp_path / "spectrum.csv")
    again = hpc_gfmd.make_surface(
        "spectrum", path=str(tmp_path / "spectrum.csv"), n=(256, 256), seed=2, physical_sizes=SIZES
    )
    assert hpc_gfmd.spectrum_of(again).roughness().g_rms == pytest.approx(0.1, rel=0.05)


def test_a_spectrum_names_heights_that_it_lacks():
    """Of the longest waves, of which there are few; bins without waves are no rows."""
    keys = {"hurst": 0.8, "lam_l_over_lam_s": 16, "lam_s_over_a": 4, "seed": 4}
    wall = hpc_gfmd.make_surface("self-affine", L_over_lam_l=2, **keys)
    spectrum = hpc_gfmd.spectrum_of(wall)
    assert f"of the heights {wall.heights.std():.3g}" in spectrum.notes[0]
    assert spectrum.roughness().h_rms < 0.95 * wall.heights.std()
    assert spectrum.C.min() > 1e-12 * spectrum.C.max()
    with pytest.raises(SceneError, match=r"^spectrum_of: found waves in less than two bins"):
        hpc_gfmd.spectrum_of(hpc_gfmd.make_surface("wave", amplitude=0.01, n=(64, 64)))


def of_container(topography):
    from SurfaceTopography.Container.SurfaceContainer import InMemorySurfaceContainer

    return hpc_gfmd.spectrum_of(InMemorySurfaceContainer([topography]))


def of_profiles(topography):
    return hpc_gfmd.spectrum_of(topography, of="profiles")


@pytest.mark.parametrize("of", [hpc_gfmd.spectrum_of, of_profiles, of_container])
def test_spectrum_of_a_scan(wall, of):
    """A tilted piece in nm, its spectrum through a window, from the map and from its profiles."""
    n = 180
    of_wall = hpc_gfmd.spectrum_of(wall)
    z = 1e9 * wall.heights[:n, :n] + 20 * np.arange(n)[:, None]
    spectrum = of(Topography(z, (n / 256 * 1e5,) * 2, unit="nm").detrend("height"))
    slopes = [rows.between(Q[0], Q[-1]).roughness().g_rms for rows in (spectrum, of_wall)]
    assert slopes[0] == pytest.approx(slopes[1], rel=0.1)
    assert spectrum.unit == "m"


def test_waves_that_the_tip_does_not_show_are_left_out(wall):
    tip = {"instrument": {"parameters": {"tip_radius": {"value": 20, "unit": "um"}}}}
    blunt = Topography(1e9 * wall.heights, (1e5, 1e5), unit="nm", periodic=True, info=tip)
    assert hpc_gfmd.spectrum_of(blunt).q[-1] < hpc_gfmd.spectrum_of(wall).q[-1] / 2
    assert len(hpc_gfmd.spectrum_of(blunt, reliable=False).q) == len(hpc_gfmd.spectrum_of(wall).q)


def test_what_the_library_refuses_is_an_error_of_the_user_and_a_mistake_is_not(wall):
    for wrong in ({"per_decade": "a"}, {"window": "none such"}):
        with pytest.raises(SceneError, match=r"^spectrum_of: "):
            hpc_gfmd.spectrum_of(wall, **wrong)
    with pytest.raises(SceneError, match=r"^spectrum_of: .*none such"):
        hpc_gfmd.spectrum_of(wall.heights, physical_sizes=wall.sizes, detrend="none such")
    container = SimpleNamespace(power_spectrum=lambda unit: None)  # is called with more
    with pytest.raises(TypeError, match="unexpected keyword"):
        hpc_gfmd.spectrum_of(container)


def test_extension_to_finer_waves_by_its_own_exponent():
    q = np.geomspace(1.0, 100.0, 40)
    spectrum = hpc_gfmd.Spectrum(q, q**-3.6)
    extended = spectrum.extended(2 * np.pi / 1000)
    whole = hpc_gfmd.Spectrum(q[[0, -1]] * [1, 10], (q[[0, -1]] * [1, 10]) ** -3.6)
    assert extended.at([500.0]) == pytest.approx(whole.at([500.0]), rel=1e-9)
    share = 1 - (spectrum.roughness().g_rms / whole.roughness().g_rms) ** 2
    assert f"H = 0.8: {100 * share:.0f} % of g_rms^2" in extended.notes[-1]
    with pytest.raises(SceneError, match=r"shortest: found 1\.0, allowed: a number below"):
        spectrum.extended(1.0)
    for wrong in (0, -0.01, "1 nm", np.nan):
        with pytest.raises(SceneError, match=rf"shortest: found {wrong}, allowed: a number below"):
            spectrum.extended(wrong)
    for wrong in (0, 1.0, "3", np.inf):
        with pytest.raises(SceneError, match=rf"over: found {wrong}, allowed: a number greater"):
            spectrum.extended(0.01, wrong)
