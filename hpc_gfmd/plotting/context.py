"""What all panels of a picture of one result share."""

from typing import Any

from ..output.read import Result
from ..output.summary import converged
from .theories import scene_of, theory_of
from .units import Units, good
from .window import window_of


class FigureContext:
    """A result as it is drawn.

    result: with the chosen steps alone; left_out: how many others there are; window: (x0, x1, y0,
    y1) in the unit of its sizes, points: the same in grid points; hardness: of the solid, None
    without one; units, theory, lengths: how it is scaled, and what is drawn beside it; dpi: of the
    print; attracts: whether the surfaces do; name: in a legend of several results."""

    def __init__(
        self,
        result: Result,
        chosen: list[int],
        window: Any = None,
        dpi: float | None = None,
        dimensionless: bool = False,
        name: str = "",
    ) -> None:
        self.result, self.dpi, self.name = result.some(chosen), dpi, name
        self.left_out = len(result.steps) - len(chosen)
        self.window, self.points = window_of(result.surface, window)
        scene = scene_of(result)
        self.theory = theory_of(scene, result.surface)
        self.hardness = scene.material.hardness if scene else None
        self.attracts = scene is not None and scene.material.adhesion is not None
        self.units = Units(result, self.theory, dimensionless)
        # 1 where all varies along one axis alone
        self.dimensions = 1 if 0 in getattr(scene and scene.surface, "periods", ()) else 2
        x0, x1, y0, y1 = self.window
        self.lengths = self.units.of("length", [x1 - x0, y1 - y0])

    def name_of(self, k: int) -> str:
        """Name the k-th of the chosen steps by its number and load."""
        step, name = self.result.steps[k], f"step {self.result.indices[k]}"
        pressures = self.units.of("pressure", [step.get("p")])
        if self.units.rough and pressures.relative and good(step.get("p_star")):
            name += f": $p^* = {step['p_star']:.3g}$"
        elif good(step.get("p")):
            name += f": {pressures.value('p_0', step['p'])}"
        doubt = f"\nNOT CONVERGED ({step.get('status', 'unknown')})"
        return name + ("" if converged(step) else doubt)
