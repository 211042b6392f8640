"""What all panels of a picture of one result share."""

from typing import Any

from ..output.result import Result
from ..output.summary import converged, last_held
from .theories import scene_of, theory_of
from .units import Units, good
from .window import window_of


class FigureContext:
    """A result with what all panels of a picture of it share: units, window, theory.

    Raises SceneError if the window is not a part of the cell.

    Parameters
    ----------
    result : Result
        Not changed.
    chosen : list of int
        Indices in result.steps of the load steps to draw.
    window : (x0, x1, y0, y1), optional
        Part of the cell, as `window_of` takes it; default: all of it.
    dpi : float, optional
        Resolution of the print.
    dimensionless : bool
        Whether to ignore the units of the result.
    name : str
        Name in a legend of several results.

    Attributes
    ----------
    result : Result
        With the chosen load steps only.
    dpi, name
        As given.
    pull_off : dict or None
        The last load step before the surfaces separate, chosen or not; None if they do not.
    left_out : int
        Number of load steps that are not chosen.
    window : (x0, x1, y0, y1)
        In the unit of the sizes.
    points : (i0, i1, j0, j1) or None
        The window in grid points; None: all of them.
    hardness : float or None
        Hardness of the solid, in the unit of the pressure.
    attracts : bool
        Whether the surfaces attract each other.
    theory : Theory or None
        Drawn beside the result.
    units : Units
        Scales of all kinds of quantities.
    lengths : Scale
        Scale of positions within the window.
    """

    def __init__(
        self,
        result: Result,
        chosen: list[int],
        window: Any = None,
        dpi: float | None = None,
        dimensionless: bool = False,
        name: str = "",
    ) -> None:
        self.result = result.some(chosen)
        self.pull_off = last_held(result.steps)
        self.dpi = dpi
        self.name = name
        self.left_out = len(result.steps) - len(chosen)
        self.window, self.points = window_of(result.surface, window)
        scene = scene_of(result)
        self.theory = theory_of(scene, result.surface)
        self.hardness = scene.material.hardness if scene else None
        self.attracts = scene is not None and scene.material.adhesion is not None
        self.units = Units(result, self.theory, dimensionless)
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
