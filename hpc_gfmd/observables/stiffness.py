"""Contact stiffness from the load sweep."""


def stiffness(contact):
    """-dp/d(mean gap) as the secant from the load before; None for the first load."""
    before = contact.before
    if before is None or before[1] == contact.gap_mean:
        return None
    return (contact.p - before[0]) / (before[1] - contact.gap_mean)


OBSERVABLES = {"stiffness": stiffness}
