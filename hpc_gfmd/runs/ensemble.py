"""Statistics of several results with the same loads, such as many realisations or scans."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact import all_numbers, observables_named
from ..output.numbers import unit_of
from ..output.summary import converged, with_error
from ..util.errors import SceneError
from .solution import Solution
from .solutions import Solutions, load
from .table import EFFORT, RESULTS, TARGETS, aligned, column_scale, html, named_observables

if TYPE_CHECKING:
    from pandas import DataFrame

    from ..plotting.style import Figure

SAME_LOAD = 1e-6  # relative
LOADS = (*TARGETS, "p", "p_star")  # one of these is the same in all results
NO_MEAN = {*TARGETS, *EFFORT, "iterations", "seed"}


class Ensemble:
    """Several results with the same loads: mean and standard deviation of their numbers.

    Parameters
    ----------
    results : iterable of Solutions, Solution or path
        What `solve_many` or `solve` returned, or result files; at least two.

    Attributes
    ----------
    results : list of Solutions
        One for each surface.
    load : str
        The number that is the same in all results: "p", "p_star", "target_a_r", ...
    loads : ndarray, shape (loads,)
        Its values.

    Raises
    ------
    SceneError
        For less than two results, for an exception among them (as `solve_many` yields), and for
        different loads or units.

    Examples
    --------
    >>> ensemble = hpc_gfmd.Ensemble(hpc_gfmd.solve_many(walls, p_star=[0.01, 0.1]))
    >>> ensemble.mean("a_r"), ensemble.std("a_r")
    """

    def __init__(self, results: Iterable[Solutions | str | PathLike]) -> None:
        self.results = [_solutions(result, k) for k, result in enumerate(results, 1)]
        if len(self.results) < 2:
            raise SceneError(f"ensemble: found {len(self.results)} results, allowed: two or more")
        if len({len(result) for result in self.results}) > 1:
            numbers = ", ".join(str(len(result)) for result in self.results)
            raise SceneError(f"ensemble: found {numbers} loads, allowed: as many in each result")
        units = {(result.unit, result.pressure_unit) for result in self.results}
        if len(units) > 1:
            raise SceneError("ensemble: found different units, allowed: the same in each result")
        alike = [name for name in LOADS if self._is_alike(name)]
        if not alike:
            raise SceneError(
                "ensemble: found different loads, allowed: the same pressures, p_star or targets"
            )
        self.load = alike[0]
        self.loads = self.results[0].values(self.load)

    def __len__(self) -> int:
        return len(self.results)

    def _is_alike(self, name: str) -> bool:
        """Whether a number is there and the same in all results, load by load, within SAME_LOAD."""
        if any(name not in step for result in self.results for step in result.result.steps):
            return False
        values = np.array([result.values(name) for result in self.results], dtype=float)
        return bool(np.allclose(values, values[0], rtol=SAME_LOAD, atol=0))

    def values(self, name: str) -> np.ndarray:
        """Return a number of all loads of all results, shape (results, loads).

        nan for a load without a value. It is computed where a result does not have it, as by
        `Solution.value`. SceneError for what is no number, such as "status".
        """
        values = np.array([result.values(name) for result in self.results])
        if values.dtype.kind not in "fiub":
            raise SceneError(f"observable: found {name!r}, which is no number, allowed: numbers")
        return values.astype(float)

    def mean(self, name: str) -> np.ndarray:
        """Return the mean of a number over the results, shape (loads,).

        nan for a load at which one of the results has no value.
        """
        return self.values(name).mean(axis=0)

    def std(self, name: str) -> np.ndarray:
        """Return the sample standard deviation of a number over the results, shape (loads,).

        It divides by the number of results less 1. nan for a load at which one of them has no
        value or is infinite.
        """
        with np.errstate(invalid="ignore"):  # inf less inf
            return self.values(name).std(axis=0, ddof=1)

    def leak_rate(
        self,
        viscosity: float | str,
        pressure_drop: float | str,
        width: float | str | None = None,
        length: float | str | None = None,
        axis: str = "x",
    ) -> np.ndarray:
        """Return the mean leak rate over the results, as `Solutions.leak_rate`.

        Parameters
        ----------
        viscosity, pressure_drop, width, length, axis
            As for `Solutions.leak_rate`.

        Returns
        -------
        ndarray, shape (loads,)
            In m^3/s.
        """
        fluid = viscosity, pressure_drop, width, length, axis
        return np.mean([result.leak_rate(*fluid) for result in self.results], axis=0)

    def leak_rate_error(self, axis: str = "x") -> np.ndarray:
        """Return the relative error of `leak_rate` for one more piece, shape (loads,).

        The standard deviation over the results and their mean error by solver and grid, added as
        independent ones; the mean of N results is better known by sqrt(N) in the former. Not that
        of the theory. inf where all are tight on their grids.

        Parameters
        ----------
        axis : {"x", "y"}
            Direction of the flow.
        """
        cubes = self.values(f"critical_gap_{axis}") ** 3  # proportional to the rates
        of_grid = [result.leak_rate_error(axis) for result in self.results]
        with np.errstate(invalid="ignore", divide="ignore"):
            errors = np.where(cubes > 0, cubes * of_grid, 0.0).mean(axis=0)
            relative = np.hypot(cubes.std(axis=0, ddof=1), errors) / cubes.mean(axis=0)
        return np.where(np.isnan(relative), np.inf, relative)

    @property
    def names(self) -> list[str]:
        """Names of the numbers that all loads of all results have and of which a mean makes sense.

        Targets of loads, FFT pairs, times, iterations and seeds are left out.
        """
        steps = [step for result in self.results for step in result.result.steps]
        return [
            name
            for name, value in steps[0].items()
            if name not in NO_MEAN
            and isinstance(value, int | float)
            and all(isinstance(step.get(name), int | float) for step in steps)
        ]

    def to_dataframe(self) -> DataFrame:
        """Return a pandas table with a row for each load.

        For `load` and each number NAME of `names` it has the columns NAME (the mean) and NAME_std
        (the standard deviation). `attrs["units"]` holds {column: unit}.
        """
        from pandas import DataFrame

        surface = self.results[0].result.surface
        columns = {}
        units: dict[str, str] = {}
        for name in [self.load, *(name for name in self.names if name != self.load)]:
            unit = unit_of(name, surface, all_numbers())
            columns[name] = self.mean(name)
            columns[f"{name}_std"] = self.std(name)
            units |= {name: unit, f"{name}_std": unit}
        table = DataFrame(columns)
        table.attrs["units"] = units
        return table

    def plot(self, what: str = "curves", **how: Any) -> Figure:
        """Draw numbers against the load, as a matplotlib figure.

        Up to six results are drawn one by one, more as their mean and a band of the standard
        deviation.

        Parameters
        ----------
        what : str
            "curves", or the name of one number.
        **how
            As for `hpc_gfmd.plot`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .plot import plot

        return plot(self.results, what, **how)

    def table(self) -> str:
        """Return a table as text, one line per load, with means +- standard deviations."""
        remarks = [f"+-: standard deviation over {len(self)} results", *self._failures()]
        return "\n".join([*aligned(self._cells()), *remarks])

    def _failures(self) -> list[str]:
        """Return a line on loads that are not converged in some results, if there are any."""
        failed = [
            f"{count} of {len(self)} results at load {k}"
            for k, steps in enumerate(zip(*(result.result.steps for result in self.results)))
            if (count := sum(not converged(step) for step in steps))
        ]
        return [f"NOT CONVERGED: {', '.join(failed)}"] if failed else []

    def _cells(self) -> list[list[str]]:
        """Return the cells of the table as texts: a row of headings, one of units, one per load."""
        surface = self.results[0].result.surface
        observables = observables_named(named_observables(self.results[0].result))
        names = [
            name for name in (*RESULTS, *observables) if name in self.names and name != self.load
        ]
        headings = TARGETS | RESULTS
        columns = []
        for name in dict.fromkeys([self.load, *names]):
            mean = self.mean(name)
            deviation = self.std(name)
            scale, unit = column_scale(name, mean.tolist(), surface)
            texts = [
                f"{value / scale:.4g}"
                if name in LOADS and self._is_alike(name)
                else with_error(float(value / scale), float(sigma / abs(value)) if value else None)
                for value, sigma in zip(mean, deviation, strict=True)
            ]
            columns.append([headings.get(name, name), unit, *texts])
        return [list(row) for row in zip(*columns, strict=True)]

    def __repr__(self) -> str:
        return f"<ensemble of {len(self)} results>\n{self.table()}"

    def _repr_html_(self) -> str:
        remarks = [f"mean and standard deviation of {len(self)} results", *self._failures()]
        return html(self._cells(), remarks)


def _solutions(result: Any, number: int) -> Solutions:
    """Return the Solutions of member `number` (from 1) of an ensemble, read from its file if it is
    a path; SceneError if it is an exception.
    """
    if isinstance(result, Exception):
        raise SceneError(f"ensemble: result {number} is an error ({result}), allowed: solutions")
    if isinstance(result, Solution):
        return Solutions(
            result.steps, lambda: result.result, result.rows, result.comm, status=result.status
        )
    return result if isinstance(result, Solutions) else load(result)
