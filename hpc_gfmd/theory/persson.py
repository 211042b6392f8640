"""Persson's contact mechanics theory: contact area, pressures, mean gap, stiffness, energy.

Dimensionless pressure p_star = p0/(E* g_rms); eps_f = lam_s/lam_l. Self-affine spectra between the
two cutoffs, or any isotropic spectrum C(q). The mean gap follows from the elastic energy (Yang &
Persson; eqs. gap and elasticEnergy of Prodanov, Dapp & Muser 2014):

    gap = (2 pi)^(-1/2) int_0^g_rms dg/q(g) F(x),   x = sqrt(2) p0/(E* g),
    F(x) = gamma E1(x^2) + 6 (1-gamma) int_1^inf erf(tx)^2 exp(-t^2 x^2) dt/t,

with g(q) the rms gradient of the roughness up to q. For a self-affine spectrum this is eq. gapFinal
of the paper, but for the 6, which is printed there as 3; printed=True gives the published number.

gamma (0 to 1.5, beyond which the energy would not rise with load) is the empirical factor for the
energy stored in partial contact: 0.42 in the literature (Persson 2007; Yang & Persson 2008), 1 in
the original theory. Integrals are good to 1e-10. Functions take arrays of pressures and raise
SceneError for numbers out of range: p_star >= 0, hurst in [0, 1], eps_f in [1e-100, 1].
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf, erfc

from ..util.errors import SceneError
from . import kernels
from .checks import within
from .slope_profile import SlopeProfile

GAMMA = 0.42
KAPPA_LOW_LOAD = np.sqrt(8 / np.pi)  # lim a_r/p_star for p_star -> 0


def contact_area(p_star: ArrayLike) -> np.ndarray:
    """Compute the relative contact area, eq. contAreaExact; independent of H and eps_f.

    Parameters
    ----------
    p_star : float or array
        p0/(E* g_rms) >= 0.

    Returns
    -------
    float or array
        a_r = erf(sqrt(2) p_star), in the shape of p_star.
    """
    return erf(np.sqrt(2) * _pressure(p_star))


def noncontact_area(p_star: ArrayLike) -> np.ndarray:
    """Compute 1 - a_r for p_star as in `contact_area`, accurate also if a_r is close to 1."""
    return erfc(np.sqrt(2) * _pressure(p_star))


def kappa(p_star: ArrayLike) -> np.ndarray:
    """Compute a_r/p_star for p_star as in `contact_area`; the limit sqrt(8/pi) at p_star = 0."""
    p_star = _pressure(p_star)
    tiny = p_star < 1e-12
    return np.where(tiny, KAPPA_LOW_LOAD, contact_area(p_star) / np.where(tiny, 1.0, p_star))[()]


def pressure_distribution(
    p: ArrayLike, p0: ArrayLike, g_rms: float = 1.0, E_star: float = 1.0
) -> np.ndarray:
    """Compute the probability density of the local pressure, eq. pressDist.

    Parameters
    ----------
    p, p0 : float or array
        Local and mean pressure in the unit of E_star; they broadcast.
    g_rms, E_star : float
        Rms gradient and effective modulus, > 0.

    Returns
    -------
    float or array
        Density per unit of pressure, 0 for p <= 0. Its integral is a_r (points without contact, 1 -
        a_r, have p = 0), its first moment p0.
    """
    width = _positive("E_star", E_star) * _positive("g_rms", g_rms) / 2
    p = np.asarray(p, dtype=float) / width
    p0 = _pressure(p0, "p0") / width
    # the difference of the two Gaussians, written so that neither overflows nor cancels
    offset = np.minimum(np.abs(p - p0), 40)
    mirror = np.minimum(np.maximum(p, 0), 1e150) * np.minimum(p0, 1e150)
    density = -np.exp(-(offset**2) / 2) * np.expm1(-2 * mirror)
    return np.where(p > 0, density / (np.sqrt(2 * np.pi) * width), 0.0)[()]


def g_rms_lam_s_over_h_rms(hurst: float, eps_f: float) -> float:
    """Return g_rms lam_s/h_rms of a self-affine spectrum with sharp cutoffs.

    Parameters
    ----------
    hurst, eps_f : float
        As for `mean_gap`.

    Returns
    -------
    float
    """
    return 2 * np.pi * float(eps_f) / SlopeProfile.self_affine(hurst, eps_f).h_rms


def mean_gap(
    p_star: ArrayLike,
    hurst: float,
    eps_f: float,
    gamma: float = GAMMA,
    printed: bool = False,
    unit: str = "h_rms",
) -> np.ndarray:
    """Compute the mean gap of a self-affine wall, eq. gapFinal.

    Parameters
    ----------
    p_star : float or array
        p0/(E* g_rms) >= 0.
    hurst, eps_f : float
        Hurst exponent in [0, 1], and lam_s/lam_l in [1e-100, 1].
    gamma : float
        Factor of the energy in partial contact, 0 to 1.5.
    printed : bool
        Whether to use the equation as published, with 3 instead of 6 (see `theory.persson`).
    unit : {"h_rms", "g_rms_lam_s"}
        The length that the gap is given in.

    Returns
    -------
    float or array
        In the shape of p_star; infinite at p_star = 0; above p_star of about 19 it underflows to 0.

    Raises
    ------
    SceneError
        If a number is out of range or the unit is unknown.
    """
    profile = SlopeProfile.self_affine(hurst, eps_f)
    return _gap(profile, _pressure(p_star), gamma, printed) / _length(profile, eps_f, unit)


def stiffness(
    p_star: ArrayLike,
    hurst: float,
    eps_f: float,
    gamma: float = GAMMA,
    printed: bool = False,
    unit: str = "h_rms",
) -> np.ndarray:
    """Compute the contact stiffness -dp_star/d(gap/unit) of a self-affine wall.

    Parameters
    ----------
    p_star, hurst, eps_f, gamma, printed, unit
        As for `mean_gap`.

    Returns
    -------
    float or array
        In units of E* g_rms/h_rms, or of E*/lam_s with unit="g_rms_lam_s", in the shape of p_star.
        Tends to p_star (unit length)/(decay length of the gap) for p_star -> 0 and overflows to inf
        in full contact.
    """
    profile = SlopeProfile.self_affine(hurst, eps_f)
    gamma = _gamma(gamma)
    p_star = _pressure(p_star)
    slope = profile.integrate(
        p_star, lambda x: kernels.compliance_kernel(x, gamma, printed), power=1
    )
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # in units of g_rms/q_min
        compliance = np.where(p_star > 0, slope / np.sqrt(2 * np.pi) / p_star, np.inf)[()]
        return _length(profile, eps_f, unit) / compliance


def elastic_energy(
    p_star: ArrayLike, hurst: float, eps_f: float, gamma: float = GAMMA
) -> np.ndarray:
    """Compute the elastic energy per nominal area of a self-affine wall, eq. elasticEnergy.

    Parameters
    ----------
    p_star, hurst, eps_f, gamma
        As for `mean_gap`.

    Returns
    -------
    float or array
        In units of E* g_rms h_rms, in the shape of p_star; 0 at p_star = 0.
    """
    profile = SlopeProfile.self_affine(hurst, eps_f)
    gamma = _gamma(gamma)
    share = profile.integrate(
        _pressure(p_star), lambda x: kernels.energy_fraction(x, gamma), power=2
    )
    return np.where(np.asarray(p_star) > 0, share / (2 * profile.h_rms), 0.0)[()]


def mean_gap_spectrum(
    q: ArrayLike,
    C: ArrayLike,
    p0: ArrayLike,
    E_star: float = 1.0,
    gamma: float = GAMMA,
    printed: bool = False,
    area: float = 1.0,
) -> np.ndarray:
    """Compute the mean gap of a surface with any isotropic spectrum under the pressure p0.

    Parameters
    ----------
    q : array, shape (m,)
        Increasing wave vectors.
    C : array, shape (m,), or function of q
        The spectrum at q, interpolated by power laws; a function is also sampled between the q.
    p0, E_star : float or array, float
        Mean pressure and effective modulus in one unit.
    gamma, printed
        As for `mean_gap`.
    area : float
        Normalises C by h_rms^2 = area/(2 pi)^2 int C d^2q: 1 for the two-dimensional power spectral
        density of surface metrology, A0 for C = |h_q|^2 of one period of nominal area A0 (the
        paper), (2 pi)^2 for Persson's C.

    Returns
    -------
    float or array
        In the unit of 1/q and the shape of p0; infinite at p0 = 0.

    Raises
    ------
    SceneError
        If q does not increase, C is not positive, or a number is out of range.
    """
    profile = SlopeProfile.from_spectrum(q, C, area)
    p_star = _pressure(p0, "p0") / (_positive("E_star", E_star) * profile.g_rms)
    return _gap(profile, p_star, gamma, printed) * profile.g_rms / profile.q_min


def curve(
    p_star: ArrayLike, hurst: float, eps_f: float, gamma: float = GAMMA, printed: bool = False
) -> dict[str, np.ndarray]:
    """Compute contact area, mean gap and stiffness at once, as `hpc-gfmd persson` prints them.

    Parameters
    ----------
    p_star, hurst, eps_f, gamma, printed
        As for `mean_gap`.

    Returns
    -------
    dict of arrays in the shape of p_star
        p_star, a_r, kappa, gap_over_h_rms, gap_over_g_rms_lam_s, stiffness, stiffness_lam_s.
    """
    arguments = (hurst, eps_f, gamma, printed)
    return {
        "p_star": np.asarray(p_star, dtype=float),
        "a_r": contact_area(p_star),
        "kappa": kappa(p_star),
        "gap_over_h_rms": mean_gap(p_star, *arguments),
        "gap_over_g_rms_lam_s": mean_gap(p_star, *arguments, "g_rms_lam_s"),
        "stiffness": stiffness(p_star, *arguments),
        "stiffness_lam_s": stiffness(p_star, *arguments, "g_rms_lam_s"),
    }


def _gap(profile: SlopeProfile, p_star: np.ndarray, gamma: float, printed: bool) -> np.ndarray:
    """Compute the mean gap in units of g_rms/q_min, inf where p_star is 0; checks gamma."""
    gamma = _gamma(gamma)
    gap = profile.integrate(
        p_star, lambda x: kernels.gap_kernel(x, gamma, printed), power=1
    ) / np.sqrt(2 * np.pi)
    return np.where(p_star > 0, gap, np.inf)[()]


def _length(profile: SlopeProfile, eps_f: float, unit: str) -> float:
    """Return the length of this unit name, by which gaps are divided, over g_rms/q_min."""
    if unit == "h_rms":
        return profile.h_rms
    if unit == "g_rms_lam_s":
        return 2 * np.pi * float(eps_f)
    raise SceneError(f"unit: found {unit!r}, allowed: 'h_rms', 'g_rms_lam_s'")


def _pressure(p_star: ArrayLike, name: str = "p_star") -> np.ndarray:
    """Return pressures as a float array; raise SceneError if any is negative or not finite."""
    return within(name, p_star, 0, np.inf)


def _positive(name: str, value: ArrayLike) -> float:
    """Return value as a float; raise SceneError if it is not positive and finite."""
    return float(within(name, value, 0, np.inf, open_low=True))


def _gamma(gamma: ArrayLike) -> float:
    """Return gamma as a float. Raises SceneError if it is not between 0 and 1.5."""
    return float(within("gamma", gamma, 0, 1.5))
