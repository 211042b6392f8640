"""Whether the contact percolates, and whether the gap does (an open channel for a fluid).

A periodic surface has no edges to connect. A cluster percolates along x if it contains a closed
path that goes around the cell along x (wrapping, Newman and Ziff 2001); then it is infinite along x
when the cell is repeated. Reaching from one edge of the cell to the other (spanning) is neither
necessary nor sufficient. Points that share a side are connected, as in patches.py: a fluid does not
pass between two points in contact that share a corner. With names that end in _8 it does pass, and
contact connects across corners, too: if no side-connected contact goes around, a corner-connected
gap does. On random surfaces both happen near a contact area of 0.40 (`python scripts/paper
percolation`; 0.42: Dapp, Luecke, Persson, Mueser 2012); the truth is between the two.

gap_spans_x: whether the gap reaches along x from edge to edge of a cell that is periodic along y
only: a fluid that enters at one edge of a seal leaves at the other. In a finite cell it does so up
to larger contact areas.
"""

from .base import Contact, Observable

ON_REQUEST = True
SOURCES = ("Newman, Ziff, Phys. Rev. E 64 (2001) 016706, doi:10.1103/PhysRevE.64.016706",)


def _percolates(
    name: str, axis: int, corners: bool = False, open_axis: int | None = None
) -> Observable:
    """Return the observable that is true if the contact, or the gap, percolates along an axis.

    `name` is "contact" or "gap". With `open_axis` a cluster percolates along that axis if it
    reaches from edge to edge, otherwise if it goes around the periodic cell. The observable is
    collective.
    """

    def percolates(contact: Contact) -> bool:
        """Whether the contact, or the gap, percolates. Collective."""
        return contact.clusters(name == "contact", corners, open_axis).percolates[axis]

    along = "xy"[axis]
    across = "yx"[axis]
    way = (
        f"goes around the cell along {along}, periodic along both axes"
        if open_axis is None
        else f"reaches along {along} from edge to edge, periodic along {across} alone"
    )
    meaning = f"whether the {name} {way}" + ", also by corners" * corners
    return Observable(percolates, meaning, sources=SOURCES)


def _all(corners: bool) -> dict[str, Observable]:
    """Return {name: Observable}: whether contact and gap go around the cell along x, along y.

    With `corners` points that share only a corner are connected, too, and the names end in _8.
    """
    end = "_8" if corners else ""
    return {
        f"{name}_percolates_{'xy'[axis]}{end}": _percolates(name, axis, corners)
        for name in ("contact", "gap")
        for axis in (0, 1)
    }


SPANNING: dict[str, Observable] = {
    f"gap_spans_{'xy'[axis]}": _percolates("gap", axis, open_axis=axis) for axis in (0, 1)
}
OBSERVABLES = _all(False) | _all(True) | SPANNING
TOGETHER = {
    "percolation": tuple(_all(False)),
    "percolation_8": tuple(_all(True)),
    "spanning": tuple(SPANNING),
}
