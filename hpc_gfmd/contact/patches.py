"""Contact patches and open channels: numbers, sizes, percolation, critical constriction of a leak.

Points that share a side are connected, also across periodic borders; names in _8 connect corners
too, since whether those would be connected on a finer grid is unknown. On random surfaces both
percolate near a contact area of 0.40 (0.42: Dapp, Luecke, Persson, Mueser 2012); the truth is
between the two. On periodic surfaces a cluster percolates along x if a closed path goes around the
cell along x (Newman and Ziff 2001). gap_spans_x is for cells periodic along y only: a fluid enters
at one edge of a seal and leaves at the other.

Critical constriction: the largest level t at which points with a gap of at least t connect one edge
with the opposite one; most of the fluid's pressure drops there (Persson and Yang 2008).
"""

from functools import partial

import numpy as np

from .base import Arrays, Contact, Distribution, Observable

ON_REQUEST = True
BINS_PER_OCTAVE = 2
ROUNDED = 1e-9  # of a centre, over the length of the axis
NEWMAN_ZIFF = ("Newman, Ziff, Phys. Rev. E 64 (2001) 016706, doi:10.1103/PhysRevE.64.016706",)
PERSSON_YANG = (
    "Persson, Yang, J. Phys.: Condens. Matter 20 (2008) 315011, doi:10.1088/0953-8984/20/31/315011",
)


def perimeter(contact: Contact) -> float:
    """Return the length of the edges of all patches. Collective.

    Sides between contact and open points are 4/pi times the length of an edge without preferred
    direction (Cauchy and Crofton); contacts along one axis only count them fully.
    """
    along_x, along_y, *_ = contact.edges
    a_x, a_y = contact.grid.spacings
    return average_direction(contact) * (along_x * a_x + along_y * a_y)


def average_direction(contact: Contact) -> float:
    """Return the mean length of an edge over that of its grid-cell sides, see `perimeter`."""
    return 1.0 if 1 in contact.grid.nominal else np.pi / 4


def _area(contact: Contact) -> float:
    a_x, a_y = contact.grid.spacings
    return a_x * a_y


def _of_patches(corners: bool) -> dict[str, Observable]:
    """Return {name: Observable} of number, largest and mean area of patches. Collective."""
    suffix = "_8" if corners else ""
    shared = "a side or a corner" if corners else "a side"

    def number(contact: Contact) -> int:
        """Return the number of patches on all ranks. Collective."""
        return int(contact.grid.comm.sum([len(contact.clusters(corners=corners).sizes)])[0])

    def largest(contact: Contact) -> float:
        """Return the area of the largest patch on all ranks, 0 without one. Collective."""
        of_rank = contact.clusters(corners=corners).sizes.max(initial=0)
        return float(contact.grid.comm.max([of_rank])[0]) * _area(contact)

    def mean(contact: Contact) -> float | None:
        """Return the mean area of the patches, None without one. Collective."""
        patches = number(contact)
        return contact.contact_points * _area(contact) / patches if patches else None

    return {
        f"patches{suffix}": Observable(
            number, f"number of contact patches: points that touch and share {shared}"
        ),
        f"patch_largest{suffix}": Observable(largest, "area of the largest patch", "length^2"),
        f"patch_mean{suffix}": Observable(
            mean, "mean area of the patches", "length^2", absent="nothing touches"
        ),
    }


def sizes(corners: bool, contact: Contact) -> Arrays | None:
    """Return edges (1, 2, 3, 4, 6, 8, 12, ... points) and density of patch areas; None without
    patches. Collective.
    """
    comm = contact.grid.comm
    of_rank = contact.clusters(corners=corners).sizes
    largest = comm.max([of_rank.max(initial=0)])[0]
    if largest == 0:
        return None
    octaves = int(np.log2(largest)) + 1
    edges = np.unique(np.ceil(2.0 ** (np.arange(BINS_PER_OCTAVE * octaves + 1) / BINS_PER_OCTAVE)))
    edges = edges[: np.searchsorted(edges, largest, "right") + 1]
    counts = comm.sum(np.histogram(of_rank, edges)[0])
    return {
        "edges": edges * _area(contact),
        "density": counts / counts.sum() / (np.diff(edges) * _area(contact)),
    }


def patch_table(contact: Contact) -> Arrays:
    """Return {column: array} of patches, largest first, on one process: area, load (force), x and y
    (centre), perimeter, periodic (across a border).
    """
    from scipy import ndimage
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    grid = contact.grid
    periodic = contact.periodic
    rows = grid.inside[0]
    mask = contact.touching(0, rows)
    labels, number = ndimage.label(mask)
    across = [
        np.stack([labels.take(-1, axis), labels.take(0, axis)]) for axis in (0, 1) if periodic[axis]
    ]
    pairs = np.concatenate([np.zeros((2, 0), int), *across], axis=1) - 1
    pairs = pairs[:, (pairs >= 0).all(axis=0)]
    graph = coo_array((np.ones(pairs.shape[1]), tuple(pairs)), (number, number))
    patches, patch = connected_components(graph, directed=False)
    of = patch[labels[mask] - 1]
    count = np.bincount(of, minlength=patches)

    def mean(values: np.ndarray) -> np.ndarray:
        """Return the mean over each patch of values at the points in contact."""
        return np.bincount(of, values, patches) / count

    table: Arrays = {"area": count * _area(contact)}
    p = contact.pressure_rows(0, rows)[mask].astype(np.float64) * contact.pressure_unit
    table["load"] = mean(p) * table["area"]
    sides = np.zeros(patches)
    for axis, name in enumerate("xy"):
        n = mask.shape[axis]
        position = np.nonzero(mask)[axis].astype(np.float64)
        centre = np.zeros(patches)
        if periodic[axis]:
            turns = np.exp(2j * np.pi / n * position)
            centre = np.angle(mean(turns.real) + 1j * mean(turns.imag)) * n / (2 * np.pi)
            position = (position - centre[of] + n / 2) % n - n / 2  # from the centre
        place = (centre + mean(position)) % n
        place[n - place < ROUNDED * n] = 0.0  # a little below 0 is n
        table[name] = place * grid.spacings[axis]
        for way in (-1, 1):
            beside = np.roll(mask, way, axis)
            if not periodic[axis]:  # where the surface ends there is no edge of the contact
                beside[(slice(None),) * axis + (min(way, 0),)] = True
            edge = ~beside[mask]
            sides += np.bincount(of[edge], minlength=patches) * grid.spacings[1 - axis]
    table["perimeter"] = average_direction(contact) * sides
    table["periodic"] = np.isin(np.arange(patches), patch[pairs.ravel()])
    order = np.argsort(-count, kind="stable")
    return {name: values[order] for name, values in table.items()}


def _percolates(
    name: str, axis: int, corners: bool = False, open_axis: int | None = None
) -> Observable:
    """Return the observable whether contact or gap percolates along an axis: from edge to edge
    along `open_axis`, else around the cell. Collective.
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
    return Observable(percolates, meaning, sources=NEWMAN_ZIFF)


def _percolation(corners: bool) -> dict[str, Observable]:
    """Return {name: Observable}: whether contact and gap go around the cell along x, along y."""
    end = "_8" if corners else ""
    return {
        f"{name}_percolates_{'xy'[axis]}{end}": _percolates(name, axis, corners)
        for name in ("contact", "gap")
        for axis in (0, 1)
    }


def critical_gap(axis: int, contact: Contact) -> float | None:
    """Return the largest t for which gaps >= t connect the edges, 0 without a channel. Collective.
    Exact: bisection over the bits of the gap, which have the order of the numbers.
    """
    if contact.is_separated:
        return None
    rows, points = contact.grid.inside
    g = contact.g[:rows, :points]
    comm = contact.grid.comm
    whole = np.dtype(f"i{g.dtype.itemsize}")

    def bits(value: float) -> int:
        """Return the bit pattern of a gap as an integer."""
        return int(g.dtype.type(value).view(whole))

    def spans(level: float) -> bool:
        """Whether points with a gap of at least `level` reach from edge to edge. Collective."""
        wide = contact.clusters_of(lambda i0, i1: g[i0:i1] >= level, open_axis=axis)
        return wide.percolates[axis]

    low = 0
    high = bits(comm.max([g.max(initial=0)])[0])
    while low < high:
        level = whole.type((low + high + 1) // 2).view(g.dtype)
        if spans(level):
            low = bits(comm.min([g.min(where=g >= level, initial=np.inf)])[0])
        else:
            high = bits(comm.max([g.max(where=g < level, initial=0)])[0])
    return float(whole.type(low).view(g.dtype)) * contact.surface.height_unit


TABLE_UNITS = {
    "area": "length^2",
    "load": "force",
    "x": "length",
    "y": "length",
    "perimeter": "length",
    "periodic": "",
}
SIDES = _of_patches(False)
CORNERS = _of_patches(True)
SPANNING: dict[str, Observable] = {
    f"gap_spans_{'xy'[axis]}": _percolates("gap", axis, open_axis=axis) for axis in (0, 1)
}
CRITICAL_GAPS = {
    f"critical_gap_{'xy'[axis]}": Observable(
        partial(critical_gap, axis),
        f"largest t for which points with a larger gap reach along {'xy'[axis]} from edge to edge",
        "length",
        PERSSON_YANG,
        absent="the bodies are separated",
    )
    for axis in (0, 1)
}
OBSERVABLES = {
    "perimeter": Observable(
        perimeter, "length of the edges of all patches, average over directions", "length"
    ),
    **SIDES,
    **CORNERS,
    **_percolation(False),
    **_percolation(True),
    **SPANNING,
    **CRITICAL_GAPS,
}
TOGETHER = {
    "patches": tuple(SIDES),
    "patches_8": tuple(CORNERS),
    "percolation": tuple(_percolation(False)),
    "percolation_8": tuple(_percolation(True)),
    "spanning": tuple(SPANNING),
    "critical_gap": tuple(CRITICAL_GAPS),
}
DISTRIBUTIONS = {
    f"patches{suffix}": Distribution(
        partial(sizes, corners),
        f"distribution of the areas of the patches{suffix}: share of them per area",
        {"edges": "length^2", "density": "1/length^2"},
    )
    for suffix, corners in (("", False), ("_8", True))
}
