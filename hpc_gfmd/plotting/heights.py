"""The map of heights that are in memory, such as those of a prepared surface."""

import json
from pathlib import Path
from typing import Any

from ..output.fields import Slab
from ..output.result import Result
from .pictures import plot
from .style import Picture


def height_map(
    heights: Any,
    sizes: tuple[float, ...] = (1.0, 1.0),
    unit: str = "",
    title: str = "surface",
    window: Any = None,
    dpi: float | None = None,
) -> Picture:
    """Draw a map of heights.

    Parameters
    ----------
    heights : ndarray, shape (n_x, n_y)
        Peaks up.
    sizes : (L_x, L_y)
        Lengths of the cell, in the unit of the heights.
    unit : str
        "m", or "" if lengths have no unit.
    title : str
        Title of the picture.
    window, dpi
        As for `plot`.

    Returns
    -------
    matplotlib.figure.Figure
        A new figure.

    Raises
    ------
    SceneError
        If the window is not a part of the cell.
    """
    surface = {
        "n": list(heights.shape),
        "physical_sizes": list(sizes),
        "h_rms": float(heights.std()),
        "unit": unit,
    }
    fields: Any = {"heights": Slab(heights, 0, heights.shape)}
    head = {"scene": f"title = {json.dumps(title)}"}
    result = Result(
        Path(title), surface, [{"status": "converged"}], [0], "converged", head, [fields]
    )
    return plot(result, "heights", window=window, dpi=dpi)
