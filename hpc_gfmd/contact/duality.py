"""The duality gap G of the certificate, and the bounds that follow from it without any estimate.

With e = u - u* the distance from the solution, <e, K e> <= 2 G. So the pressure is wrong by at most
sqrt(2 G K_max) (L2), and by what is left of it out of contact, where it is not counted; the mean
gap, without a hardness, by at most |e|_K (|u*|_K/p0 + |v|_S)/N, see certificate/error_estimates.py.
Errors of rounding and of the operator (Body.error) come on top. Half an FFT pair, so only on
request (and for solvers without error estimates).
"""

import numpy as np

from .base import Contact, Observable


def duality_gap(contact: Contact) -> float | None:
    """Return G/(p0 gap_mean), which bounds the error of the energy from above (see
    certificate/certificate.py); None where it was not asked for."""
    return contact.certificate.duality_gap


def pressure_bound(contact: Contact) -> float | None:
    """Bound the relative L2 error of the pressure field; None where the duality gap was not asked
    for, where the error reaches the pressure itself, and with an attraction: the distance to the
    equilibrium is that to the contact under the same attraction over a stability that is estimated.
    """
    energy = _energy_norm(contact)
    certificate = contact.certificate
    if energy is None or contact.attraction is not None:
        return None
    grid = contact.grid
    left = certificate.residual * contact.p_mean / contact.pressure_unit * np.sqrt(grid.N)
    wrong = energy * np.sqrt(contact.body.bounds(grid)[1]) + left
    return _relative(wrong, certificate.pressures)


def gap_bound(contact: Contact) -> float | None:
    """Bound the relative error of the mean gap; None as for the pressure, and with a hardness: gaps
    and dents together have a bound then, the gaps alone have none."""
    from ..operators.problem import self_energy  # names of observables need no kernels

    energy = _energy_norm(contact)
    certificate = contact.certificate
    if energy is None or contact.hardness is not None or contact.attraction is not None:
        return None
    p0 = contact.p_mean / contact.pressure_unit
    grid = contact.grid
    norm = np.sqrt(max(certificate.uKu, 0.0)) + energy
    return _relative(energy * (norm / p0 + self_energy(grid)) / grid.N, certificate.gap_mean)


def _energy_norm(contact: Contact) -> float | None:
    """Return |e|_K at most; None where it is not known."""
    certificate = contact.certificate
    if certificate.duality_gap is None or not np.isfinite(certificate.duality_gap):
        return None
    p0 = contact.wall_pressure / contact.pressure_unit
    gap = certificate.duality_gap * p0 * certificate.gap_mean * contact.N
    return float(np.sqrt(2 * gap))


def _relative(wrong: float, value: float) -> float | None:
    """Return what is wrong over the true value, at most."""
    if wrong == 0:
        return 0.0
    return float(wrong / (value - wrong)) if wrong < value else None


BOUNDS = {
    "pressure_bound": Observable(
        pressure_bound, "bound of the relative error of the pressure field (L2), but for rounding"
    ),
    "gap_bound": Observable(
        gap_bound, "bound of the relative error of gap_mean, but for rounding; none with a hardness"
    ),
}
OBSERVABLES = {
    "duality_gap": Observable(
        duality_gap, "bound of the error of the energy, over mean pressure times mean gap"
    )
} | BOUNDS
TOGETHER = {"error_bounds": tuple(BOUNDS)}
