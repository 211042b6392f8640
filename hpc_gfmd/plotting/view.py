"""What all panels of a picture of one result share."""

from typing import Any

import numpy as np

from ..output.result import Result
from ..output.summary import converged, last_held
from ..util.errors import SceneError, one_line
from ..util.quantities import parse
from .scales import Units, good
from .theory import scene_of, theory_beside


class View:
    """Load steps of a result with units, theory and window of a picture of them.

    `left_out` steps are not chosen; pull_off: last step before separation, or None; window: (x0,
    x1, y0, y1), points: (i0, i1, j0, j1), None for all; remembers: loads follow from each other;
    lengths: the Scale of positions.
    """

    def __init__(
        self,
        result: Result,
        chosen: list[int],
        window: Any = None,
        dpi: float | None = None,
        dimensionless: bool = False,
        name: str = "",
        persson: bool = False,
    ) -> None:
        self.result = result.some(chosen)
        self.pull_off = last_held(result.steps)
        self.dpi = dpi
        self.name = name
        self.left_out = len(result.steps) - len(chosen)
        self.window, self.points = window_of(result.surface, window)
        scene = scene_of(result)
        self.theory = theory_beside(result, persson)
        self.hardness = scene.material.hardness if scene else None
        self.attracts = scene is not None and scene.material.adhesion is not None
        self.remembers = scene is not None and scene.remembers
        height = self.theory.height if self.theory else None
        self.units = Units(result.surface, result.steps, height, dimensionless)
        x0, x1, y0, y1 = self.window
        self.lengths = self.units.of("length", [x1 - x0, y1 - y0])

    def name_of(self, k: int) -> str:
        """Return the label of result.steps[k]: number, load, and a mark if not converged."""
        step = self.result.steps[k]
        name = f"step {self.result.indices[k]}"
        pressures = self.units.of("pressure", [step.get("p")])
        if self.units.rough and pressures.relative and good(step.get("p_star")):
            name += f": $p^* = {step['p_star']:.3g}$"
        elif good(step.get("p")):
            name += f": {pressures.value('p_0', step['p'])}"
        doubt = f"\nNOT CONVERGED ({step.get('status', 'unknown')})"
        return name + ("" if converged(step) else doubt)


def window_of(surface: Any, window: Any) -> tuple:
    """Return a window at edges of grid points, and its points (i0, i1, j0, j1); None for all."""
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
