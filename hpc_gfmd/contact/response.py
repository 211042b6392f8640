"""Stiffness, conductance and elastic energy, and strict bounds of errors by the duality gap.

Conductance (heat, current): flow into a half-space solves the problem of its displacement, so per
area, without films and with an insulating gap, it is the contact stiffness times 2 k1 k2/(k1 + k2)
over E* (Barber 2003), with conductivities k1, k2.

Bounds: with e = u - u* the error of the displacement, |e|_K^2 = <e, K e> <= 2 G, the duality gap.
So the L2 error of the pressure is at most sqrt(2 G K_max), plus the pressure left out of contact;
that of the mean gap, without a hardness, at most |e|_K (|u*|_K/p0 + |v|_S)/N with the self-energy
|v|_S of the nominal area, see certificate/error_estimates.py. Rounding and Body.error come on top.
"""

from math import inf, isfinite

import numpy as np

from .base import Contact, Observable

ON_REQUEST = ("stiffness", "conductance")


def stiffness(contact: Contact) -> float | None:
    """Return -dp/d(mean gap) at fixed contact points, to `contact.accuracy`; takes FFT pairs.
    Collective.

    None with an attraction, in full contact, without contact, or if the accuracy was not reached.
    """
    if contact.attraction is not None:
        return None
    compliance = contact.tangent.compliance
    return (
        contact.pressure_unit / (compliance * contact.surface.height_unit)
        if 0 < compliance < inf
        else None
    )


def conductance(contact: Contact) -> float | None:
    """Return the conductance per area over 2 k1 k2/(k1 + k2), in 1/length: stiffness over E_star,
    of the gap on a periodic surface, of the approach with free edges along both axes, else None.
    Collective.
    """
    from ..bodies.halfspace import HalfSpace

    if not isinstance(contact.body, HalfSpace):
        return None
    tangent = contact.tangent
    compliance = tangent.compliance if all(contact.periodic) else tangent.approach
    slope = contact.surface.slope / contact.surface.height_unit
    return slope / compliance if 0 < compliance < inf else None


def energy(contact: Contact) -> float | None:
    """Return the elastic energy per area, (E*/4) sum_q |q| |u_q|^2 (eq. elaEnerg2D) on a half-
    space; None for one that is periodic along one axis only.
    """
    return contact.energy if isfinite(contact.energy) else None


def duality_gap(contact: Contact) -> float | None:
    """Return G over N p gap (certificate/certificate.py), which bounds the energy's error."""
    return contact.certificate.duality_gap


def pressure_bound(contact: Contact) -> float | None:
    """Return an upper bound of the relative L2 error of the pressure, without rounding; None
    without a finite duality gap, if not below 1, and with an attraction.
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
    """Return an upper bound of the relative error of the mean gap; None as `pressure_bound`, and
    with a hardness.
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
    """Return an upper bound of |e|_K, program's units; None without a finite duality gap."""
    certificate = contact.certificate
    if certificate.duality_gap is None or not np.isfinite(certificate.duality_gap):
        return None
    p0 = contact.wall_pressure / contact.pressure_unit
    gap = certificate.duality_gap * p0 * certificate.gap_mean * contact.N
    return float(np.sqrt(2 * gap))


def _relative(wrong: float, value: float) -> float | None:
    """Return wrong/(value - wrong), an upper bound of the relative error of a value, or None."""
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
DUALITY = {
    "duality_gap": Observable(
        duality_gap, "bound of the error of the energy, over mean pressure times mean gap"
    )
} | BOUNDS
OBSERVABLES = DUALITY | {
    "stiffness": Observable(
        stiffness,
        "-dp/d(gap_mean), the tangent of the load curve, positive",
        "pressure/length",
        absent="full contact has an infinite one, no contact has none, and with adhesion it is not"
        " computed",
    ),
    "conductance": Observable(
        conductance,
        "contact conductance per nominal area, over 2 k1 k2/(k1 + k2) or 2/(rho1 + rho2); with free"
        " edges the spreading resistance of the lone body counts",
        "1/length",
        ("Barber, Proc. R. Soc. A 459 (2003) 53, doi:10.1098/rspa.2002.1038",),
        absent="layers and coatings have none (heat passes through another body than pressure),"
        " nor have full contact, no contact, and free edges along one axis alone",
    ),
    "energy": Observable(
        energy,
        "elastic energy of the deformation over the nominal area, positive",
        "pressure length",
    ),
}
TOGETHER = {"error_bounds": tuple(BOUNDS)}
