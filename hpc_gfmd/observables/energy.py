"""Elastic energy per area."""


def energy(contact):
    """U/A = (E*/4) sum_q |q| |u_q|^2 (eq. elaEnerg2D)."""
    return contact.energy


OBSERVABLES = {"energy": energy}
