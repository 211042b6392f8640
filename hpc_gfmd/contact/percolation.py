"""Whether the contact percolates, and whether the gap does: an open channel for a fluid. True or
false, along x and along y.

Periodic surfaces have no edges to connect: a cluster percolates along x where it holds a closed way
that goes around the cell along x (wrapping, Newman and Ziff 2001), that is where it has no end
along x if the cell is repeated. Reaching from one edge of the cell to the other (spanning) is
neither needed nor enough. Points are connected where they share a side, as those of patches.py: a
fluid does not pass between two points that touch and share a corner. By names that end in _8 it
does, and contact passes, too: where no contact that shares sides goes around, a gap that shares
corners does. At random both happen near a contact area of 0.40 (`python scripts/paper percolation`;
0.42: Dapp, Luecke, Persson, Mueser 2012), the truth being between the two.

gap_spans_x: whether the gap reaches along x from edge to edge, the cell being periodic along y
alone: a fluid that enters along one edge of a seal comes out at the other. In a finite cell it does
so up to larger contact areas.
"""

from .base import Contact, Observable

ON_REQUEST = True
SOURCES = ("Newman, Ziff, Phys. Rev. E 64 (2001) 016706, doi:10.1103/PhysRevE.64.016706",)


def _percolates(
    name: str, axis: int, corners: bool = False, open_axis: int | None = None
) -> Observable:
    """Make the observable whether contact or gap (name) percolates along an axis."""

    def percolates(contact: Contact) -> bool:
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
    """Return the observables of percolation around the cell by name; corners: points also connect
    diagonally."""
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
