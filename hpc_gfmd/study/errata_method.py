"""Errata of the paper's formulas and of its algorithm, each shown by a small computation made here and now.

Every function returns {"printed", "right", "shown"}; ERRATA lists them.
"""

import numpy as np
from scipy.integrate import quad

from ..theory import persson
from . import paper
from .errata_gfmd import HURST, N_SMALL, STEPS, gfmd, small_surface
from .levels import P_HIGH, P_LOW

EPS_F = 1 / 1024  # of the examples, at H = HURST


def erratum(printed, right, shown):
    """One row of the table."""
    return {"printed": printed, "right": right, "shown": shown}


def parseval():
    """h_rms and g_rms from the transform."""
    z = small_surface()
    z_q = np.fft.fft2(z) / z.size
    with_n, without = np.sum(np.abs(z_q) ** 2) / z.size / np.mean(z**2), np.sum(np.abs(z_q) ** 2) / np.mean(z**2)
    return erratum(
        "h_rms² = (1/N) Σ |h_q|², g_rms² likewise (eqs. barH, barG)",
        "no 1/N with the transform that the paper states, nor in its eq. totalBroad",
        f"on a {z.shape[0]} × {z.shape[1]} surface the sum is {without:.12f} of the mean square of the heights, with 1/N "
        f"{with_n:.3g} of it",
    )


def height_scale():
    """The rms height of a self-affine spectrum."""
    whole, slope = _moment(2, EPS_F), _moment(4, EPS_F)  # of C = q^(-2-2H) from q_l = 1 to q_s, in units A_0/(2 pi) = 1
    printed = (1 - EPS_F ** (2 * HURST)) / HURST
    printed_slope = EPS_F ** (-2 + 2 * HURST) * (1 - EPS_F ** (2 - 2 * HURST)) / (2 - 2 * HURST)
    stated = np.sqrt(HURST / (1 - HURST)) * EPS_F**HURST * 2 * np.pi
    ratio = 2 * np.pi * EPS_F * np.sqrt(slope / whole)
    from_printed = 2 * np.pi * EPS_F * np.sqrt(printed_slope / printed)
    return erratum(
        "h_rms² = q_l² C(q_l)/H {1 - (q_l/q_s)^2H} (eq. scalHeight), so h_f = q_l √(C(q_l)/H)",
        "/(2H), and h_f = q_l √(C(q_l)/(2H)); both scal equations leave out A_0/(2π)",
        f"H = {HURST:g}, eps_f = 1/{1 / EPS_F:g}: the integral is {whole / printed:.6f} of the printed height, "
        f"{slope / printed_slope:.6f} of the printed slope; "
        f"g_rms lam_s/h_rms is {ratio:.5f}, as printed {from_printed:.5f}, by the paper's own relation {stated:.5f}",
    )


def slope_relation():
    """g_rms lam_s in units of h_rms."""
    parts = []
    for hurst in (0.0, 0.3, 0.5, 0.8):
        for eps_f in (1 / 16, EPS_F):
            leading = 2 * np.pi * (np.sqrt(hurst / (1 - hurst)) * eps_f**hurst if hurst else 1 / np.sqrt(-2 * np.log(eps_f)))
            parts.append(f"{persson.g_rms_lam_s_over_h_rms(hurst, eps_f) / leading - 1:+.2%} (H = {hurst:g}, 1/{1 / eps_f:g})")
    return erratum(
        "g_rms lam_s = 2π h_rms √(H/(1-H)) eps_f^H",
        "only to leading order: times √((1 - eps_f^(2-2H))/(1 - eps_f^2H))",
        "exact over leading order: " + ", ".join(parts),
    )


def short_wave_height():
    """The rms height of the roughness on the shortest wavelengths."""
    last = _moment(2, EPS_F, from_q=1 / EPS_F / np.e)
    claim = np.sqrt(2 - 2 * HURST) * np.sqrt(_moment(4, EPS_F)) * 2 * np.pi * EPS_F
    return erratum(
        "rms height of the shortest wavelengths of order √(2-2H) g_rms lam_s",
        "√(2-2H) g_rms lam_s/(2π), since q_s = 2π/lam_s",
        f"H = {HURST:g}: the last factor e of wavelengths has {np.sqrt(last) / claim:.3f} of the printed height, "
        f"{2 * np.pi * np.sqrt(last) / claim:.2f} of the right one",
    )


def missing_factor():
    """The mean gap of Persson's theory from its elastic energy, by quadrature."""
    hurst, eps_f, parts = 0.8, 1 / 256, []
    for gamma in (1.0, persson.GAMMA):
        for p_star in (P_LOW, P_HIGH):
            direct = _gap_from_energy(p_star, hurst, eps_f, gamma)
            errors = [float(persson.mean_gap(p_star, hurst, eps_f, gamma, printed)) / direct - 1 for printed in (True, False)]
            parts.append(
                f"gamma = {gamma:g}, p* = {p_star:.3f}: {direct:.5f} directly, as printed {errors[0]:+.1%}, with the 6 {errors[1]:+.0e}"
            )
    return erratum(
        "eq. gapFinal: 3 (1-gamma) ∫ erf(tx)² exp(-t²x²) dt/t",
        "6 (1-gamma): E1(x²) = 2 ∫ exp(-t²x²) dt/t, so this term lacks the 2",
        "gap/h_rms by quadrature of eq. gap with eq. elasticEnergy: " + "; ".join(parts),
    )


def scaling():
    """The pressure of a surface that is stretched in the plane."""
    s, q_old, u = 2.0, 3.0, 1.0
    q_new = q_old / s
    needed = q_new * u  # (E*/2) q u, in units of E*/2
    right, printed = _old_pressure(s * q_new, q_old, u) / s, _old_pressure(q_new / s, q_old, u) / s
    return erratum(
        "p_new(q_new) = p_old(q_new/s)/s",
        "p_old(s q_new)/s, as one line before: q_new = q_old/s",
        f"one mode q_old = {q_old:g}, s = {s:g}: equilibrium needs {needed:g}; right {right:g}, printed {printed:g}",
    )


def stiffness():
    """The contact stiffness."""
    p_star, h = 0.05, 1e-4
    gaps = [float(persson.mean_gap(p, HURST, EPS_F)) for p in (p_star * (1 - h), p_star * (1 + h))]
    slope = (gaps[1] - gaps[0]) / (2 * h * p_star)
    return erratum(
        "stiffness K is the derivative of the mean gap with respect to pressure",
        "K = -dp/d(gap): the negative inverse of that",
        f"Persson theory, p* = {p_star:g}: d(gap)/dp* = {slope:.2f}, stiffness {float(persson.stiffness(p_star, HURST, EPS_F)):.4f} "
        f"= -1/{-slope:.2f}",
    )


def damping_sign():
    """Damped Verlet dynamics with the printed sign of the damping and with the other, on a small contact."""
    good, bad = gfmd(damping=-1), gfmd(damping=+1)
    return erratum(
        "GFMD: F_q ← F_q + eta (u_now - u_old)",
        "minus: the printed sign feeds energy",
        f"{N_SMALL} × {N_SMALL}, {STEPS} steps: largest speed {_range(good['speed'])} with the minus, {_range(bad['speed'])} as "
        f"printed",
    )


def load_sign():
    """The external pressure with the printed sign and with the other, on a small contact."""
    good, bad = gfmd(load=-1), gfmd(load=+1)
    return erratum(
        "GFMD: F(0) ← F(0) + p with u >= -h",
        "minus p: printed, it pulls the solids apart",
        f"mean gap/h_rms from {good['gap'][0]:.2f} to {good['gap'][-1]:.3f} with the minus (a_r = {good['a_r']:.3f}), to "
        f"{bad['gap'][-1]:.3g} as printed (a_r = {bad['a_r']:g})",
    )


def start():
    """Starting heights of the elastic solid."""
    touching, above = gfmd(), gfmd(lifted=True)
    steps = {name: _settled(run["gap"], touching["gap"][-1]) for name, run in (("touching", touching), ("above", above))}
    return erratum(
        "start: set all grid points to h_max",
        "any u >= -h will do; touching in one point (u = 0), or a coarser solution, is nearer",
        f"steps until the mean gap is within 1 % of the last: {steps['touching']} from touching, {steps['above']} from h_max; the "
        f"same mean gap "
        f"to {abs(above['gap'][-1] / touching['gap'][-1] - 1):.0e}",
    )


def rounded_pressures():
    """The two pressures."""
    parts = [
        f"{p:.7f} is printed {printed:g} ({printed / p - 1:+.2%}; corrected theory, gap at H = {HURST:g}: "
        f"{float(persson.mean_gap(printed, HURST, EPS_F)) / float(persson.mean_gap(p, HURST, EPS_F)) - 1:+.2%})"
        for p, printed in paper.PRINTED.items()
    ]
    return erratum("p* = 0.007 and 0.353", "0.01/√2 and 0.5/√2", "; ".join(parts))


def inverted_ratio():
    """The system that the text recommends for H = 0."""
    printed, grid = 1 / 512, 16
    return erratum(
        "L/lam_s = 1/512 is more than sufficient (H = 0)",
        "L/lam_s = 512: inverted",
        f"with the recommended a/lam_s = 1/{grid} the cell has {grid / printed:.0f} points along an axis, printed {grid * printed:.3f}",
    )


def _range(speed):
    return (
        f"falls from {max(speed[:20]):.2g} to {speed[-1]:.1e}"
        if speed[-1] < max(speed[:20])
        else f"grows from {max(speed[:20]):.2g} to {speed[-1]:.1e} in {len(speed)} steps"
    )


def _settled(gap, last):
    off = np.flatnonzero(np.abs(np.array(gap) / last - 1) > 0.01)
    return int(off[-1]) + 2 if off.size else 1


def _moment(power, eps_f, from_q=1.0):
    """∫ q^power C dq/q of C = q^(-2-2H) up to q_s = 1/eps_f by quadrature."""
    return quad(lambda y: np.exp((power - 2 - 2 * HURST) * y), np.log(from_q), -np.log(eps_f), epsabs=0, epsrel=1e-12)[0]


def _gap_from_energy(p_star, hurst, eps_f, gamma):
    """gap/h_rms = ∫ (dU/dp)/p dp from p_star up (eq. gap), integrated by parts, with the energy of eq. elasticEnergy."""

    def energy(p):
        return float(persson.elastic_energy(p, hurst, eps_f, gamma))

    top = 40.0  # full contact: the energy no longer changes
    rest = quad(lambda y: (energy(np.exp(y)) - energy(p_star)) * np.exp(-y), np.log(p_star), np.log(top), epsrel=1e-9, limit=300)[0]
    return rest + (energy(top) - energy(p_star)) / top


def _old_pressure(q, q_mode, u):
    return q * u if q == q_mode else 0.0


ERRATA = (
    parseval,
    height_scale,
    slope_relation,
    short_wave_height,
    scaling,
    stiffness,
    missing_factor,
    damping_sign,
    load_sign,
    start,
    rounded_pressures,
    inverted_ratio,
)
