"""The map of heights that are an array, such as those of a prepared surface."""

import json
from pathlib import Path

from ..fields import Slab
from ..output.read import Result
from .pictures import plot


def height_map(heights, sizes=(1.0, 1.0), unit="", title="surface", window=None, dpi=None):
    """The picture of heights (n_x, n_y), peaks up, on a cell of these sizes; unit: "m" where both are in it; window, dpi: see plot.
    Returns a matplotlib Figure."""
    surface = {"n": list(heights.shape), "physical_sizes": list(sizes), "h_rms": float(heights.std()), "unit": unit}
    result = Result(Path(title), surface, [{"status": "converged"}], [0], "converged", {"scene": f"title = {json.dumps(title)}"},
                    [{"heights": Slab(heights, 0, heights.shape)}])
    return plot(result, "heights", window=window, dpi=dpi)
