"""The part of the cell that maps show."""

from math import ceil
from typing import Any

from ..util.errors import SceneError, one_line
from ..util.quantities import parse


def window_of(surface: Any, window: Any = None) -> tuple:
    """((x0, x1, y0, y1) in the unit of the sizes, at the edges of grid points; the same as points,
    or None for all of them).

    surface: attributes of a result; window: four numbers, or texts such as "2um". Raises
    SceneError.
    """
    sizes, n = surface.get("physical_sizes", (1.0, 1.0)), surface["n"]
    if window is None:
        return (0.0, sizes[0], 0.0, sizes[1]), None
    try:
        x0, x1, y0, y1 = map(_length, window)
        inside = 0 <= x0 < x1 <= sizes[0] * (1 + 1e-9) and 0 <= y0 < y1 <= sizes[1] * (1 + 1e-9)
    except (TypeError, ValueError):
        inside = False
    if not inside:
        found = one_line(
            " ".join(map(str, window)) if isinstance(window, list | tuple) else str(window)
        )
        low, high = (f"{size:g} {surface.get('unit', '')}".rstrip() for size in sizes)
        raise SceneError(
            f"window: found {found}, allowed: x0 x1 y0 y1 with 0 <= x0 < x1 <= {low} and 0 <= y0 <"
            f' y1 <= {high}, plain or as "2um"'
        )
    i0, i1 = _points(x0, x1, sizes[0], n[0])
    j0, j1 = _points(y0, y1, sizes[1], n[1])
    a_x, a_y = sizes[0] / n[0], sizes[1] / n[1]
    return (i0 * a_x, i1 * a_x, j0 * a_y, j1 * a_y), (i0, i1, j0, j1)


def _length(edge: Any) -> float:
    try:
        return float(edge)
    except ValueError:
        return float(parse(edge, "length"))


def _points(low: float, high: float, size: float, n: int) -> tuple[int, int]:
    first = min(int(low / size * n + 1e-9), n - 1)
    return first, min(max(first + 1, ceil(high / size * n - 1e-9)), n)
