"""Interface law: contact area, gap, stiffness, conductance, ... against the mean pressure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from ..util.errors import SceneError
from .unit_systems import SYSTEMS, converted, system_of

if TYPE_CHECKING:
    from pandas import DataFrame

LOAD_AT = "a load at "  # begins the line of InterfaceLaw.about on a load that is not converged
QUANTITIES = ("a_r", "gap_mean", "stiffness", "conductance")  # of a law, by default


@dataclass(frozen=True, eq=False)
class InterfaceLaw:
    """Quantities of a rough interface as functions of the mean pressure.

    Attributes
    ----------
    pressure : ndarray, shape (k,)
        Mean pressures over the nominal area, ascending, in `units["pressure"]`.
    values : dict of str to ndarray, shape (k,)
        Quantities by their names in a result file, as means over the surfaces. nan where a quantity
        has no value (the stiffness in full contact).
    errors : dict of str to ndarray, shape (k,)
        Estimated relative errors of `values`: that of the solver, plus that of the grid where it is
        estimated (as in tables), plus that of interpolation in the intervals beside the pressure.
    scatter : dict of str to ndarray, shape (k,)
        Standard deviations over the surfaces, in the units of `values`; 0 for a single surface.
    gap_at_touch : float
        Mean gap when the highest point just touches, at zero pressure; in the unit of lengths.
    units : dict of str to str
        Unit of "pressure", "gap_at_touch" and of each quantity: "Pa", "m", "1/m", ...; "1" if
        dimensionless, "" if the unit is unknown.
    surfaces : int
        Number of surfaces that were averaged.
    about : tuple of str
        Description of the surfaces, the material and failed loads, one line each.
    """

    pressure: np.ndarray
    values: Mapping[str, np.ndarray]
    errors: Mapping[str, np.ndarray]
    scatter: Mapping[str, np.ndarray]
    gap_at_touch: float
    units: Mapping[str, str]
    surfaces: int = 1
    about: tuple[str, ...] = ()

    def __call__(self, name: str, pressure: Any) -> Any:
        """Interpolate a quantity at some pressures.

        Parameters
        ----------
        name : str
            One of `values`.
        pressure : float or array_like
            In `units["pressure"]`, within the range of the law.

        Returns
        -------
        float or ndarray
            In `units[name]`; nan where the quantity has no value.

        Raises
        ------
        SceneError
            For an unknown quantity, and for pressures outside the law.
        """
        if name not in self.values:
            raise SceneError(
                f"name: found {name!r}, allowed: one of {', '.join(map(repr, self.values))}"
            )
        pressure = np.asarray(pressure, dtype=float)
        low = self.pressure[0]
        high = self.pressure[-1]
        outside = pressure[~((pressure >= low * (1 - 1e-12)) & (pressure <= high * (1 + 1e-12)))]
        if outside.size:
            raise SceneError(
                f"pressure: found {outside.flat[0]:g}, allowed: {low:g} to {high:g}, the range of"
                " the law"
            )
        values = interpolate(self.pressure, self.values[name], np.clip(pressure, low, high))
        return float(values) if values.ndim == 0 else values

    @property
    def converged(self) -> bool:
        """Whether all loads of the law have the status "converged"; `about` names those without."""
        return not any(line.startswith(LOAD_AT) for line in self.about)

    def sealing_pressure(self, axis: str = "x") -> float:
        """Return the smallest pressure of the law at which the seal is tight.

        Parameters
        ----------
        axis : {"x", "y"}
            Direction of the flow.

        Returns
        -------
        float
            In `units["pressure"]`: the first pressure of the law with a critical gap of 0. The seal
            closes between it and the next lower pressure of the law, which was made so that the
            two differ by less than the relative error that was requested. In a law of several
            surfaces it is that at which the last of them is tight.

        Raises
        ------
        SceneError
            If the law has no critical gap along the axis, or the seal is tight or open in its whole
            range.
        """
        name = f"critical_gap_{axis}"
        if name not in self.values:
            raise SceneError(f"axis: found {axis!r}, but the law has no {name}")
        tight = np.flatnonzero(self.values[name] == 0)
        if not tight.size or tight[0] == 0:
            open_or_tight = "tight" if tight.size else "open"
            raise SceneError(
                f"sealing_pressure: the seal is {open_or_tight} along {axis} from"
                f" {self.pressure[0]:g} to {self.pressure[-1]:g}; a wider law has the load at which"
                " it closes"
            )
        return float(self.pressure[tight[0]])

    def in_units(self, name: str) -> InterfaceLaw:
        """Return the law in another consistent system of units, for programs that convert nothing.

        Parameters
        ----------
        name : {"SI", "mm-N-MPa", "um-uN-MPa"}
            The system.

        Returns
        -------
        InterfaceLaw
            The same law; `write_law` writes it in these units.

        Raises
        ------
        SceneError
            For another system, and for a law whose lengths or pressures have no units.
        """
        if name not in SYSTEMS:
            raise SceneError(f"units: found {name!r}, allowed: {', '.join(SYSTEMS)}")
        new = SYSTEMS[name]
        old = system_of(self.units["gap_at_touch"], self.units["pressure"])
        if old is None:
            raise SceneError(
                f'units: found "{name}" for a law without units, allowed: a scene whose lengths and'
                " pressures have units"
            )
        sizes = {key: converted(unit, old, new) for key, unit in self.units.items()}
        scale = {key: size for key, (size, _) in sizes.items()}
        return replace(
            self,
            pressure=self.pressure * scale["pressure"],
            values={key: values * scale[key] for key, values in self.values.items()},
            scatter={key: scatter * scale[key] for key, scatter in self.scatter.items()},
            gap_at_touch=self.gap_at_touch * scale["gap_at_touch"],
            units={key: unit for key, (_, unit) in sizes.items()},
        )

    def to_dataframe(self) -> DataFrame:
        """Return a pandas table, a row for each pressure, with NAME, NAME_error (relative),
        NAME_scatter.

        `attrs["units"]` holds {column: unit}.
        """
        from pandas import DataFrame

        columns = {"pressure": self.pressure}
        units = {"pressure": self.units["pressure"]}
        for name, values in self.values.items():
            columns[name] = values
            columns[f"{name}_error"] = self.errors[name]
            columns[f"{name}_scatter"] = self.scatter[name]
            units |= {name: self.units[name], f"{name}_error": "1"}
            units |= {f"{name}_scatter": self.units[name]}
        table = DataFrame(columns)
        table.attrs["units"] = units
        return table

    def __repr__(self) -> str:
        unit = self.units["pressure"]
        number = f", mean of {self.surfaces} surfaces" if self.surfaces > 1 else ""
        return (
            f"<law of an interface: {', '.join(self.values)} at {len(self.pressure)} pressures from"
            f" {self.pressure[0]:.4g} to {self.pressure[-1]:.4g} {unit}".rstrip()
            + f"{number}>"
        )


def interpolate(pressure: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Interpolate values >= 0 (nan if unknown) monotonically, in log-log, at ascending pressures; 0
    from the first 0 on (a closed seal), and the last positive value up to there.
    """
    exists = np.isfinite(values)
    positive = exists & (values > 0)
    result = np.full(np.shape(at), np.nan)
    if exists.any():
        first_zero = pressure[exists & ~positive].min(initial=np.inf)
        result = np.where((at >= first_zero) & (at <= pressure[exists].max()), 0.0, result)
    if positive.any():
        inside = (at >= pressure[positive][0] * (1 - 1e-12)) & (
            at <= pressure[positive][-1] * (1 + 1e-12)
        )
        if positive.sum() == 1:
            curve = np.full(np.shape(at), values[positive][0])
        else:
            logarithm = PchipInterpolator(np.log(pressure[positive]), np.log(values[positive]))
            within = np.clip(at, pressure[positive][0], pressure[positive][-1])
            curve = np.exp(logarithm(np.log(within)))
        result = np.where(inside, curve, result)
        # between the last open load and the first tight one the seal counts as open
        gap = (at > pressure[positive][-1]) & ~np.isfinite(result)
        if (exists & ~positive).any():
            result = np.where(gap & (at < first_zero), values[positive][-1], result)
    return result
