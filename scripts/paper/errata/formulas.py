"""Errata of the paper's formulas and of its algorithm, each shown by a small computation."""

import numpy as np
from scipy.integrate import quad

from hpc_gfmd.theory import persson

from ..printed import PRINTED
from ..rows import PRESSURES
from .dynamics import HURST as H
from .dynamics import N_SMALL, gfmd, small_surface

EPS_F = 1 / 1024  # of the examples
GRID = 16  # lam_s/a that the text recommends for H = 0


def parseval(_tables: object) -> str:
    z = small_surface()
    share = np.sum(np.abs(np.fft.fft2(z) / z.size) ** 2) / np.mean(z**2)
    return (
        f"on a {z.shape[0]} × {z.shape[1]} surface the sum is {share:.12f} of the mean square of"
        f" the heights, with 1/N {share / z.size:.3g} of it"
    )


def height_scale(_tables: object) -> str:
    # C = q^(-2-2H) from q_l = 1 to q_s, in units A_0/(2 pi) = 1
    height, slope = (_moment(power, EPS_F) for power in (2, 4))
    printed = (1 - EPS_F ** (2 * H)) / H
    printed_slope = EPS_F ** (-2 + 2 * H) * (1 - EPS_F ** (2 - 2 * H)) / (2 - 2 * H)
    stated = np.sqrt(H / (1 - H)) * EPS_F**H * 2 * np.pi
    ratio, from_printed = (
        2 * np.pi * EPS_F * np.sqrt(square) for square in (slope / height, printed_slope / printed)
    )
    return (
        f"H = {H:g}, eps_f = 1/{1 / EPS_F:g}: the integral is {height / printed:.6f} of the printed"
        f" height, {slope / printed_slope:.6f} of the printed slope; g_rms lam_s/h_rms is"
        f" {ratio:.5f}, as printed {from_printed:.5f}, by the paper's own relation {stated:.5f}"
    )


def slope_relation(_tables: object) -> str:
    parts = []
    for hurst in (0.0, 0.3, 0.5, 0.8):
        for eps_f in (1 / 16, EPS_F):
            power = np.sqrt(hurst / (1 - hurst)) * eps_f**hurst
            leading = 2 * np.pi * (power if hurst else 1 / np.sqrt(-2 * np.log(eps_f)))
            difference = persson.g_rms_lam_s_over_h_rms(hurst, eps_f) / leading - 1
            parts.append(f"{difference:+.2%} (H = {hurst:g}, 1/{1 / eps_f:g})")
    return "exact over leading order: " + ", ".join(parts)


def short_wave_height(_tables: object) -> str:
    claim = np.sqrt(2 - 2 * H) * np.sqrt(_moment(4, EPS_F)) * 2 * np.pi * EPS_F
    share = np.sqrt(_moment(2, EPS_F, from_q=1 / EPS_F / np.e)) / claim
    return (
        f"H = {H:g}: the last factor e of wavelengths has {share:.3f} of the printed height, "
        f"{2 * np.pi * share:.2f} of the right one"
    )


def scaling(_tables: object) -> str:
    s = 2.0
    q_old = 3.0
    u = 1.0
    q_new = q_old / s
    needed = q_new * u  # (E*/2) q u, in units of E*/2
    # p_old has this one mode
    right, printed = ((q * u if q == q_old else 0.0) / s for q in (s * q_new, q_new / s))
    return (
        f"one mode q_old = {q_old:g}, s = {s:g}: equilibrium needs {needed:g}; right {right:g},"
        f" printed {printed:g}"
    )


def stiffness(_tables: object) -> str:
    p_star = 0.05
    h = 1e-4
    low, high = (float(persson.mean_gap(p, H, EPS_F)) for p in (p_star * (1 - h), p_star * (1 + h)))
    slope = (high - low) / (2 * h * p_star)
    return (
        f"Persson theory, p* = {p_star:g}: d(gap)/dp* = {slope:.2f}, stiffness"
        f" {float(persson.stiffness(p_star, H, EPS_F)):.4f} = -1/{-slope:.2f}"
    )


def missing_factor(_tables: object) -> str:
    hurst = 0.8
    eps_f = 1 / 256
    parts = []
    for gamma in (1.0, persson.GAMMA):
        for p_star in PRESSURES.values():
            direct = gap_from_energy(p_star, hurst, eps_f, gamma)
            printed, right = (
                float(persson.mean_gap(p_star, hurst, eps_f, gamma, printed)) / direct - 1
                for printed in (True, False)
            )
            parts.append(
                f"gamma = {gamma:g}, p* = {p_star:.3f}: {direct:.5f} directly, as printed"
                f" {printed:+.1%}, with the 6 {abs(right):.1%}"
            )
    return "gap/h_rms by quadrature of eq. gap with eq. elasticEnergy: " + "; ".join(parts)


def damping_sign(_tables: object) -> str:
    right, printed = (_range(gfmd(damping=sign)["speed"]) for sign in (-1, +1))
    return (
        f"{N_SMALL} × {N_SMALL} points: largest speed {right} with the minus, {printed} as printed"
    )


def load_sign(_tables: object) -> str:
    right = gfmd(load=-1)
    printed = gfmd(load=+1)
    return (
        f"mean gap/h_rms from {right['gap'][0]:.2f} to {right['gap'][-1]:.3f} with the minus (a_r ="
        f" {right['a_r']:.3f}), to {printed['gap'][-1]:.3g} as printed (a_r = {printed['a_r']:g})"
    )


def start(_tables: object) -> str:
    touching = gfmd()["gap"]
    lifted = gfmd(lifted=True)["gap"]
    steps = [_settling_steps(gap, touching[-1]) for gap in (touching, lifted)]
    return (
        f"steps until the mean gap is within 1 % of the last: {steps[0]} from touching, {steps[1]}"
        f" from h_max; the same mean gap to {abs(lifted[-1] / touching[-1] - 1):.0e}"
    )


def rounded_pressures(_tables: object) -> str:
    parts = []
    for name, p in PRESSURES.items():
        printed = PRINTED[name]
        change = (
            float(persson.mean_gap(printed, H, EPS_F)) / float(persson.mean_gap(p, H, EPS_F)) - 1
        )
        parts.append(
            f"{p:.7f} is printed {printed:g} ({printed / p - 1:+.2%}; corrected theory, gap at H ="
            f" {H:g}: {change:+.2%})"
        )
    return "; ".join(parts)


def inverted_ratio(_tables: object) -> str:
    return (
        f"with the recommended a/lam_s = 1/{GRID} the cell has {GRID * 512:.0f} points along an"
        f" axis, printed {GRID / 512:.3f}"
    )


def gap_from_energy(p_star: float, hurst: float, eps_f: float, gamma: float) -> float:
    """Return gap/h_rms = ∫ (dU/dp)/p dp from p_star up (eq. gap), by parts, with the energy U of
    eq. elasticEnergy."""

    def energy(p):
        return float(persson.elastic_energy(p, hurst, eps_f, gamma))

    top = 40.0  # full contact: the energy no longer changes
    rest = quad(
        lambda y: (energy(np.exp(y)) - energy(p_star)) * np.exp(-y),
        np.log(p_star),
        np.log(top),
        epsrel=1e-9,
        limit=300,
    )[0]
    return rest + (energy(top) - energy(p_star)) / top


def _moment(power, eps_f, from_q=1.0):
    """Return the integral of q^power C dq/q with C = q^(-2-2H) up to q_s = 1/eps_f."""
    return quad(
        lambda y: np.exp((power - 2 - 2 * H) * y),
        np.log(from_q),
        -np.log(eps_f),
        epsabs=0,
        epsrel=1e-12,
    )[0]


def _range(speed):
    return f"goes from {max(speed[:20]):.2g} to {speed[-1]:.1e} in {len(speed)} steps"


def _settling_steps(gap, limit):
    """Return the number of steps after which the gap stays within 1 % of a limit."""
    outside = np.flatnonzero(np.abs(np.array(gap) / limit - 1) > 0.01)
    return int(outside[-1]) + 2 if outside.size else 1
