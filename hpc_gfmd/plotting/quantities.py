"""The numbers of a load as curves show them: names, symbols, errors and units."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import hypot
from typing import Any

from .context import FigureContext
from .units import Scale, good, label

Power = tuple[str, int]  # kind of a unit, as Units.of takes it, and its power


@dataclass(frozen=True)
class PlottedQuantity:
    """A number of a load as a panel shows it.

    Attributes
    ----------
    name : str
        In words, for the axis.
    symbol : str
        In TeX; "" if there is none.
    unit : tuple of (str, int)
        Its unit as powers of "pressure", "gap" (measured like heights) and "length" (like
        positions).
    errors : tuple of str
        Keys of its relative errors in a load step; they count as independent.
    """

    name: str
    symbol: str = ""
    unit: tuple[Power, ...] = ()
    errors: tuple[str, ...] = ()

    def scales(self, contexts: Iterable[FigureContext], key: str) -> list[tuple[Scale, int]]:
        """Choose the scales of the factors of its unit so that they suit all results.

        Parameters
        ----------
        contexts : iterable of FigureContext
            One for each result.
        key : str
            Name of the number in the result file.

        Returns
        -------
        list of (Scale, int)
            Scales and their powers, in the order of `unit`.
        """
        contexts = list(contexts)
        values = [step.get(key) for context in contexts for step in context.result.steps]
        positive = [float(value) for value in values if value is not None and good(value)]
        alone = len(self.unit) == 1
        scales = []
        for kind, power in self.unit:
            roots = [value ** (1 / power) for value in positive]
            typical = roots if alone else [_typical(contexts, kind)]
            scales.append((contexts[0].units.of(kind, typical), power))
        return scales

    def label(self, scales: list[tuple[Scale, int]]) -> str:
        """Return the label of its axis, with the units of these scales and their powers."""
        if not self.symbol:
            units = " ".join(f"{scale.name}^{power}" for scale, power in scales if scale.name)
            return f"{self.name} ({units})" if units else self.name
        return f"{self.name} {label(self.symbol, *scales)}"


def _typical(contexts: list[FigureContext], kind: str) -> float:
    """Return a typical value of "pressure", "length" or any other kind (height) in the results."""
    if kind == "pressure":
        return max(float(step["p"]) for context in contexts for step in context.result.steps)
    surface = contexts[0].result.surface
    if kind == "length":
        return float(surface.get("physical_sizes", (1.0,))[0])
    return float(surface.get("h_rms") or 0.0)


AREA_ERRORS = ("a_r_error", "a_r_discretisation")
QUANTITIES = {  # by the names of the result file; the first ones are drawn by default
    "a_r": PlottedQuantity("contact area", "a_r", errors=AREA_ERRORS),
    "kappa": PlottedQuantity("", r"\kappa = a_r/p^*", errors=AREA_ERRORS),
    "gap_mean": PlottedQuantity("mean gap", r"\langle g \rangle", (("gap", 1),), ("gap_error",)),
    "approach": PlottedQuantity("approach", r"\delta", (("gap", 1),)),
    "stiffness": PlottedQuantity("stiffness", "k", (("pressure", 1), ("gap", -1))),
    "conductance": PlottedQuantity("conductance", "c", (("gap", -1),)),
    "critical_gap_x": PlottedQuantity("critical gap along x", "g_c", (("gap", 1),)),
    "critical_gap_y": PlottedQuantity("critical gap along y", "g_c", (("gap", 1),)),
    "contact_area": PlottedQuantity("contact area", "A", (("length", 2),), AREA_ERRORS),
    "contact_pressure_mean": PlottedQuantity(
        "mean pressure in contact", r"\langle p \rangle_c", (("pressure", 1),), AREA_ERRORS
    ),
    "contact_pressure_max": PlottedQuantity(
        "largest pressure", r"p_\mathrm{max}", (("pressure", 1),)
    ),
    "a_plastic": PlottedQuantity("area that yields", r"a_\mathrm{pl}"),
    "a_r_corrected": PlottedQuantity("contact area, edge-corrected", "a_r", errors=("a_r_error",)),
    "patches": PlottedQuantity("number of patches"),
    "patch_largest": PlottedQuantity("largest patch", "A_1", (("length", 2),)),
    "patch_mean": PlottedQuantity("mean patch", r"\langle A \rangle", (("length", 2),)),
    "perimeter": PlottedQuantity("length of the edges of contact", "P", (("length", 1),)),
    "energy": PlottedQuantity("elastic energy per area", "U/A", (("pressure", 1), ("gap", 1))),
    "gap_over_h_rms": PlottedQuantity("mean gap", r"\langle g \rangle/h_\mathrm{rms}"),
}
OVERVIEW = ("a_r", "kappa", "gap_mean", "approach")


def quantity_of(key: str) -> PlottedQuantity:
    """Return how a number of a load is shown; an unknown one has its key as name, and no unit."""
    return QUANTITIES.get(key) or PlottedQuantity(key.replace("_", " "))


def relative_error(quantity: PlottedQuantity, step: Mapping[str, Any]) -> float:
    """Return the relative error of a number of a load, by solver and grid together.

    Parameters
    ----------
    quantity : PlottedQuantity
    step : mapping
        Attributes of the load step.

    Returns
    -------
    float
        Root of the summed squares; an error that the load step lacks counts as 0.
    """
    return hypot(*(step.get(error) or 0.0 for error in quantity.errors))


@dataclass(frozen=True)
class LoadAxis:
    """The axis of the loads.

    Attributes
    ----------
    of : callable
        Takes the attributes of a load step, returns its load in the unit of the axis.
    pressure_of : callable
        Takes a load in the unit of the axis, returns the mean pressure in the unit of the result.
    label : str
        Label of the axis.
    """

    of: Callable[[Mapping[str, Any]], float]
    pressure_of: Callable[[Any], Any]
    label: str


def load_axis(contexts: list[FigureContext]) -> LoadAxis:
    """Return the axis of loads: forces or mean pressures.

    Forces are taken if every load of all results prescribes one and they have a unit. contexts: of
    results with at least one load each, in the same units and of the same nominal area.
    """
    steps = [step for context in contexts for step in context.result.steps]
    forces = [step.get("target_force") for step in steps]
    scale = contexts[0].units.of("force", forces)
    if all(isinstance(force, float) for force in forces) and scale.name:
        ratio = steps[0]["p"] / steps[0]["target_force"]
        return LoadAxis(
            lambda step: float(step["target_force"]) / scale.unit,
            lambda load: load * scale.unit * ratio,
            f"force {scale.label('F')}",
        )
    scale = contexts[0].units.of("pressure", [step["p"] for step in steps])
    dimensionless = scale.relative and contexts[0].units.rough
    name = r"pressure $p^* = p_0/(E^* g_\mathrm{rms})$"
    return LoadAxis(
        lambda step: float(step["p"]) / scale.unit,
        lambda load: load * scale.unit,
        name if dimensionless else f"pressure {scale.label('p_0')}",
    )
