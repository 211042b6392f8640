"""The table [material.adhesion]: the attraction of the two surfaces across the gap."""

from .table import Length, Table, Text, Work, key


class Adhesion(Table):
    """Attraction of the two surfaces across the gap.

    The energy per area is -work where they touch, and rises to 0 over the range.
    """

    work: Work = key(
        "work of adhesion per area, from contact to infinity", unit="work", example="50 mJ/m2"
    )
    range: Length = key("length over which the attraction falls", unit="length", example="2 nm")
    law: Text = key(
        "how it falls with the gap",
        "exponential",
        allowed='"exponential" or the name of another law',
    )
