"""What a picture of a result is made of."""

from typing import Any

from ..output.read import Result
from .theories import theory_of
from .units import Units, good
from .window import window_of


class Drawn:
    """What a picture is made of. result; chosen: indices into its steps; window: (x0, x1, y0, y1)
    in the unit of its sizes, points: the same in grid points; units, theory, lengths: how it is
    scaled, and what else is drawn; dpi: of the print."""

    def __init__(
        self, result: Result, chosen: list[int], window: Any, dpi: float | None, dimensionless: bool
    ) -> None:
        self.result, self.chosen, self.dpi = result, chosen, dpi
        self.window, self.points = window_of(result.surface, window)
        self.theory = theory_of(result)
        self.units = Units(result, self.theory, dimensionless)
        self.lengths = self.units.lengths(
            [self.window[1] - self.window[0], self.window[3] - self.window[2]]
        )

    def fields(self, k: int) -> dict:
        """The fields of the k-th of the chosen steps."""
        return self.result.fields[self.chosen[k]]

    def name_of(self, k: int) -> str:
        """Its step and load."""
        step, index = self.result.steps[self.chosen[k]], self.result.indices[self.chosen[k]]
        if self.units.rough and not self.units.pressure_unit and good(step.get("p_star")):
            return f"step {index}: $p^* = {step['p_star']:.3g}$"
        return (
            f"step {index}: {self.units.pressures([step['p']]).value('p_0', step['p'])}"
            if good(step.get("p"))
            else f"step {index}"
        )
