"""Contact patches: how many, how large, and how their sizes are distributed.

Points that share a side belong to one patch (4-connected), also across the border of a periodic
surface: the boundary of the contact consists of such sides, and others count so, too (scipy,
ContactMechanics). Whether two points that share only a corner would be connected on a finer grid is
unknown; names that end in _8 connect them (8-connected). Sizes are areas, in the unit of length
squared.
"""

from functools import partial

import numpy as np

from .base import Arrays, Contact, Distribution, Observable
from .perimeter import average_direction

ON_REQUEST = True
BINS_PER_OCTAVE = 2


def _area(contact: Contact) -> float:
    """Return the area of one grid point, in the unit of length squared."""
    a_x, a_y = contact.grid.spacings
    return a_x * a_y


def _of_patches(corners: bool) -> dict[str, Observable]:
    """Return {name: Observable} of the number of patches and their largest and mean area.

    With `corners` points that share a corner are connected, too, and the names end in _8. All three
    are collective; the mean is None if there is no patch.
    """
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
    """Return the distribution of patch areas. Collective.

    Parameters
    ----------
    corners : bool
        Whether points that share only a corner are connected.
    contact : Contact

    Returns
    -------
    dict of str to ndarray, or None
        "edges" of bins, two per factor of two (1, 2, 3, 4, 6, 8, 12, ... points), and "density",
        the share of the patches per area, which integrates to 1. None if there is no patch.
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
    """Return the contact patches as {column: array}, the largest patch first. On one process only.

    Columns: area, load (force on the patch), x and y (centre), perimeter, periodic (whether the
    patch continues across the border of the cell). Points that share a side are connected.
    TABLE_UNITS has the units.
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
        table[name] = (centre + mean(position)) % n * grid.spacings[axis]
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
OBSERVABLES = SIDES | CORNERS
TOGETHER = {"patches": tuple(SIDES), "patches_8": tuple(CORNERS)}
DISTRIBUTIONS = {
    f"patches{suffix}": Distribution(
        partial(sizes, corners),
        f"distribution of the areas of the patches{suffix}: share of them per area",
        {"edges": "length^2", "density": "1/length^2"},
    )
    for suffix, corners in (("", False), ("_8", True))
}
