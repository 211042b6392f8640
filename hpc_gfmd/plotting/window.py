"""The part of the cell that maps show."""

from typing import Any

import numpy as np

from ..util.errors import SceneError, one_line
from ..util.quantities import parse


def window_of(surface: Any, window: Any) -> tuple:
    """Return ((x0, x1, y0, y1) in the unit of the sizes, at the edges of grid points; the same as
    points, or None for all of them).

    surface: attributes of a result; window: four numbers, or texts such as "2um". Raises
    SceneError.
    """
    sizes, n = np.array(surface.get("physical_sizes", (1.0, 1.0))), np.array(surface["n"])
    if window is None:
        return (0.0, sizes[0], 0.0, sizes[1]), None
    try:
        low, high = np.reshape([_length(edge) for edge in window], (2, 2)).T
        inside = np.all((0 <= low) & (low < high) & (high <= sizes * (1 + 1e-9)))
    except (TypeError, ValueError):
        inside = np.False_
    if not inside:
        found = " ".join(map(str, window)) if isinstance(window, list | tuple) else str(window)
        L_x, L_y = (f"{size:g} {surface.get('unit', '')}".rstrip() for size in sizes)
        raise SceneError(
            f"window: found {one_line(found)}, allowed: x0 x1 y0 y1 with 0 <= x0 < x1 <= {L_x} and"
            f' 0 <= y0 < y1 <= {L_y}, plain or as "2um"'
        )
    first = np.minimum((low / sizes * n + 1e-9).astype(int), n - 1)
    last = np.clip(np.ceil(high / sizes * n - 1e-9).astype(int), first + 1, n)
    points = np.transpose([first, last])
    return tuple((points * (sizes / n)[:, None]).ravel()), tuple(points.ravel().tolist())


def _length(edge: Any) -> float:
    try:
        return float(edge)
    except ValueError:
        return float(parse(edge, "length"))
