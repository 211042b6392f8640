"""The duality gap G of the certificate, and the strict error bounds that follow from it.

With e = u - u* the distance of the displacement u from the exact solution u*, K the stiffness of
the body, |e|_K^2 = <e, K e> and N the number of points, |e|_K^2 <= 2 G. So the L2 error of the
pressure is at most sqrt(2 G K_max), plus the pressure that the solver leaves out of contact, which
the result sets to 0. The error of the mean gap, without a hardness, is at most
|e|_K (|u*|_K/p0 + |v|_S)/N with the mean pressure p0 and the self-energy |v|_S of the nominal area
(0 without free edges), see certificate/error_estimates.py. Errors of rounding and of the operator
(Body.error) come on top. G takes half an FFT pair, so it is computed on request only (and for
solvers without error estimates).
"""

import numpy as np

from .base import Contact, Observable


def duality_gap(contact: Contact) -> float | None:
    """Return the duality gap G over N times mean pressure of the wall times mean gap.

    It bounds the error of the energy relative to that product; see certificate/certificate.py. None
    if it was not computed.
    """
    return contact.certificate.duality_gap


def pressure_bound(contact: Contact) -> float | None:
    """Return an upper bound of the relative L2 error of the pressure field.

    Rounding is not included. None if the duality gap was not computed or is not finite, if the
    bound is not below 1, and with an attraction: there it would depend on a stability that is only
    estimated.
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
    """Return an upper bound of the relative error of the mean gap.

    None in the cases of `pressure_bound`, and with a hardness: then only gaps and dents together
    have a bound.
    """
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
    """Return an upper bound of |e|_K, the energy norm of the error of the displacement.

    e is the error of the displacement; in the program's units, with sums over points. None without
    a finite duality gap.
    """
    certificate = contact.certificate
    if certificate.duality_gap is None or not np.isfinite(certificate.duality_gap):
        return None
    p0 = contact.wall_pressure / contact.pressure_unit
    gap = certificate.duality_gap * p0 * certificate.gap_mean * contact.N
    return float(np.sqrt(2 * gap))


def _relative(wrong: float, value: float) -> float | None:
    """Return wrong/(value - wrong), an upper bound of the relative error of a computed value.

    wrong: upper bound of its absolute error. None if the error may be as large as the value.
    """
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
