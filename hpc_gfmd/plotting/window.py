"""The part of the cell that maps show."""

from typing import Any

import numpy as np

from ..util.errors import SceneError, one_line
from ..util.quantities import parse


def window_of(surface: Any, window: Any) -> tuple:
    """Check the part of the cell that maps show, and widen it to whole grid points.

    Parameters
    ----------
    surface : mapping
        Attributes of the surface.
    window : sequence of four numbers or texts, or None
        x0, x1, y0, y1 in the unit of the sizes, or as "2um"; None: all.

    Returns
    -------
    (x0, x1, y0, y1)
        In the unit of the sizes, at the edges of grid points.
    (i0, i1, j0, j1) or None
        The points i0 <= i < i1, j0 <= j < j1; None for all.

    Raises
    ------
    SceneError
        If it is not a part of the cell.
    """
    sizes = np.array(surface.get("physical_sizes", (1.0, 1.0)))
    n = np.array(surface["n"])
    if window is None:
        return (0.0, sizes[0], 0.0, sizes[1]), None
    try:
        low, high = np.reshape([_length(edge) for edge in window], (2, 2)).T
        inside = np.all((0 <= low) & (low < high) & (high <= sizes * (1 + 1e-9)))
    except (TypeError, ValueError):
        inside = np.False_
    if not inside:
        text = " ".join(map(str, window)) if isinstance(window, list | tuple) else str(window)
        L_x, L_y = (f"{size:g} {surface.get('unit', '')}".rstrip() for size in sizes)
        raise SceneError(
            f"window: found {one_line(text)}, allowed: x0 x1 y0 y1 with 0 <= x0 < x1 <= {L_x} and"
            f' 0 <= y0 < y1 <= {L_y}, plain or as "2um"'
        )
    start = np.minimum((low / sizes * n + 1e-9).astype(int), n - 1)
    stop = np.clip(np.ceil(high / sizes * n - 1e-9).astype(int), start + 1, n)
    points = np.transpose([start, stop])
    return tuple((points * (sizes / n)[:, None]).ravel()), tuple(points.ravel().tolist())


def _length(edge: Any) -> float:
    """Return a length, a number or a text such as "5 um", as a number; units become m."""
    try:
        return float(edge)
    except ValueError:
        return float(parse(edge, "length"))
