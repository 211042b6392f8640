"""Common base of one solved load and of several: files, tables and pictures of them."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from inspect import signature
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ..contact import all_numbers, all_observables, default_observables
from ..output.export import FORMATS, INSTEAD, common_fields, export, frame
from ..output.fields import Slab
from ..output.numbers import axes, dataset_attributes, numbers, scalar_names
from ..output.record import RunFile
from ..output.result import Result
from ..output.summary import critical_gap_error
from ..parallel.comm import Comm, SerialComm
from ..scene.explain import require_known
from ..util.errors import GfmdError, SceneError, how_to_install
from ..util.quantities import parse
from .references import references_of
from .table import result_table

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

    from ..plotting.style import Figure


class Solved:
    """Common base of Solution and Solutions, which has the numbers of the result as attributes.
    `steps`: those of each load; `make_result` makes the Result when it is first read; `rows`: of
    this rank.
    """

    _picture: str | None = None  # what `plot` draws by default; None: the first that is possible
    _get: Callable[[str], Any]  # a number by its name

    def __init__(
        self,
        steps: list[dict],
        make_result: Callable[[], Result],
        rows: tuple[int, int] | None = None,
        comm: Comm | None = None,
    ):
        self.steps = steps
        self.comm = comm or SerialComm()
        self._make_result = make_result
        self._rows = rows

    @classmethod
    def of(cls, result: Result) -> Self:
        """Return the solutions in a result that every process can read."""
        return cls(result.steps, lambda: result)

    @cached_property
    def result(self) -> Result:
        """All numbers and fields, by the names of the result file."""
        return self._make_result()

    @property
    def rows(self) -> tuple[int, int]:
        """Start and stop of this rank's rows of the fields."""
        return self._rows or (0, int(self.result.surface["n"][0]))

    def __reduce__(self) -> tuple:
        """Pickle with all fields in memory. Raises SceneError if they are spread over ranks."""
        if any(self.result.fields):
            self._require_whole("pickle")
        in_memory = [
            {name: Slab(stored.read(), 0, stored.shape) for name, stored in fields.items()}
            for fields in self.result.fields
        ]
        return type(self).of, (replace(self.result, fields=in_memory),)

    @property
    def notes(self) -> tuple[str, ...]:
        """What may be wrong with the surface, and what the result lacks, one line each."""
        return self.result.notes

    @property
    def g_rms(self) -> float:
        """Rms gradient of the heights on the grid."""
        return self.result.surface["g_rms"]

    @property
    def h_rms(self) -> float:
        """Rms height on the grid, in the unit of the heights."""
        return self.result.surface["h_rms"]

    @property
    def sizes(self) -> tuple[float, float]:
        """(L_x, L_y) of the surface, in the unit of the heights."""
        return tuple(self.result.surface["physical_sizes"])

    @property
    def unit(self) -> str:
        """Unit of lengths and heights: "m", or "" if none was given."""
        return self.result.surface.get("unit", "")

    @property
    def pressure_unit(self) -> str:
        """Unit of pressures: "Pa", or "" if none was given."""
        return self.result.surface.get("pressure_unit", "")

    def _number_names(self) -> Iterator[str]:
        """Yield the names of the numbers that the result has or that are cheap to compute."""
        yield from scalar_names(self.steps)
        yield from default_observables()

    def __getattr__(self, name: str) -> Any:
        """Return a number of the result; AttributeError of others says if it is computable."""
        if name.startswith("_") or name not in self._number_names():
            reason = "no such number or method"
            if not name.startswith("_") and name in all_observables():
                reason = f"was not asked for: observable({name!r}) of a Solution finds it"
            raise AttributeError(f"{name}: {reason}")
        return self._get(name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._number_names()})

    def save(self, path: str | PathLike, force: bool = False) -> Path:
        """Write a result file, as `hpc-gfmd run` does, and warn of what it replaces.

        Collective.

        Parameters
        ----------
        path : path
            The file; ends in .h5 or .hdf5.
        force : bool
            Whether to overwrite any file, or an interrupted run. By default only a result of the
            same surface, loads and settings is replaced.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        SceneError
            If the path is invalid, or something would be lost without `force`.
        GfmdError
            If writing fails.
        """
        path = Path(path)
        result = self.result
        comm = self.comm
        if path.suffix.lower() not in (".h5", ".hdf5"):
            raise SceneError(
                f"path: found {str(path)!r}, allowed: a path that ends in .h5 or .hdf5"
            )
        # how it is written is told anew
        head = {name: value for name, value in result.head.items() if name != "io"}
        with RunFile(
            comm,
            path,
            result.surface["n"],
            self.rows,
            head,
            result.surface,
            resume=False,
            force=force,
            about=all_numbers(),
        ) as file:
            for note in file.notes if comm.rank == 0 else ():
                warnings.warn(note, stacklevel=2)
            file.take(result)
            file.finish(result.status)
        return path

    def references(self) -> list[str]:
        """Return what to cite, one line each: the program and the papers behind the numbers."""
        return references_of(self.result)

    def export(self, path: str | PathLike, fields: Sequence[str] | None = None) -> Path:
        """Write a file for another program, as `hpc-gfmd export` does.

        An existing file is replaced.

        Parameters
        ----------
        path : path
            Ends in .csv (a table of the numbers) or .gwy (Gwyddion, all fields).
        fields : list of str, optional
            Fields to export; default: all.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        SceneError
            For another suffix, or if the fields are spread over ranks.
        GfmdError
            If writing fails.
        """
        self._require_whole("export")
        kind = Path(path).suffix.removeprefix(".")
        if kind not in FORMATS:
            hint = INSTEAD.get("netcdf" if kind == "nc" else kind)
            allowed = ", ".join(f".{name}" for name in FORMATS)
            raise SceneError(f"path: found {str(path)!r}, {hint or f'allowed: one in {allowed}'}")
        return export(self.result.only(fields=fields), kind, path, all_numbers())

    def leak_rate(
        self,
        viscosity: float | str,
        pressure_drop: float | str,
        width: float | str | None = None,
        length: float | str | None = None,
        axis: str = "x",
    ) -> Any:
        """Estimate the leak rate of a seal by the theory of the critical junction.

        The pressure drops at the narrowest place of the widest channel: right to an order of
        magnitude, best close to the load at which the seal is tight, too small at light loads; see
        `theory.leak.leak_rate`. The critical gap is computed if the result does not have it.

        Parameters
        ----------
        viscosity : float or str
            Viscosity of the fluid, in Pa s, or as "1 mPa s".
        pressure_drop : float or str
            Pressure drop of the fluid over the seal, in Pa, or as "1 bar".
        width, length : float or str, optional
            Extent of the seal across and along the flow; only their ratio matters. Both plain, or
            both as "30 cm". Default: a square seal.
        axis : {"x", "y"}
            Direction of the flow.

        Returns
        -------
        float, or ndarray for several loads
            Volume per time, in m^3/s if the unit of the heights is m; 0 if the seal is tight.
            `leak_rate_error` has its relative error on this surface.

        Raises
        ------
        SceneError
            For numbers out of range, for a width or a length that is alone or the only one with a
            unit, and if the result has no critical gap and lacks pressure or gap to compute it.
        """
        from ..theory.leak import leak_rate

        if axis not in ("x", "y"):
            raise SceneError(f'axis: found {axis!r}, allowed: "x" or "y"')
        critical_gap = self._get(f"critical_gap_{axis}")
        eta = _number("viscosity", viscosity, "viscosity")
        drop = _number("pressure_drop", pressure_drop, "pressure")
        if None not in (width, length) and isinstance(width, str) != isinstance(length, str):
            raise SceneError(
                f"width, length: found {width!r} and {length!r}, allowed: both with units or both"
                " plain"
            )
        across = None if width is None else _number("width", width, "length")
        along = None if length is None else _number("length", length, "length")
        rate = leak_rate(critical_gap, eta, drop, across, along)
        return float(rate) if rate.ndim == 0 else rate

    def leak_rate_error(self, axis: str = "x") -> Any:
        """Return the relative error of `leak_rate`, three times that of the critical gap.

        The critical gap has the absolute error of the mean gap, by the solver and by the grid, and
        what the grid misses at the narrowest place of the channel, 0.3 times g_rms times the
        spacing (measured: 1 in 100 are beyond). It is neither that of the theory nor the scatter of
        surfaces, which can be larger: solve several pieces, see `Ensemble.leak_rate_error`.

        Parameters
        ----------
        axis : {"x", "y"}
            Direction of the flow.

        Returns
        -------
        float, or ndarray for several loads
            inf for a seal that is tight on this grid.
        """
        if axis not in ("x", "y"):
            raise SceneError(f'axis: found {axis!r}, allowed: "x" or "y"')
        gap, critical_gap, solver, grid = (
            np.asarray(self._get(name), dtype=float)
            for name in ("gap_mean", f"critical_gap_{axis}", "gap_error", "gap_discretisation")
        )
        of_mean_gap = solver + np.nan_to_num(grid)
        error = np.asarray(
            3 * critical_gap_error(critical_gap, gap, of_mean_gap, self.result.surface)
        )
        return float(error) if error.ndim == 0 else error

    def table(self, errors: bool = False) -> str:
        """Return the table that `hpc-gfmd show` prints, as text.

        Parameters
        ----------
        errors : bool
            Whether the errors of solver and grid have columns of their own.

        Returns
        -------
        str
            A line for each load, a column for each requested observable, and notes below.
        """
        return result_table(self.result, errors)

    def to_dataframe(self) -> "DataFrame":
        """Return a pandas table, a row for each load; `attrs["units"]` holds {column: unit}."""
        return frame(self.result, all_numbers())

    def to_xarray(self) -> "Dataset":
        """Return an xarray Dataset of numbers (load), fields (load, x, y) and heights (x, y).

        Only fields that all loads have. GfmdError without xarray, SceneError if fields are spread.
        """
        try:
            from xarray import Dataset
        except ModuleNotFoundError as error:
            raise GfmdError(
                f"to_xarray: {error.name} is not installed: {how_to_install('xarray')}"
            ) from None

        self._require_whole("to_xarray")
        result = self.result
        columns = numbers(result.steps)

        def variable(name: str, dims: tuple[str, ...], values: Any) -> tuple:
            """Return (dims, values, attributes) as xarray takes them."""
            return dims, values, dataset_attributes(name, result.surface, all_numbers())

        content = {name: variable(name, ("load",), values) for name, values in columns.items()}
        for name in common_fields(result):
            values = [fields[name].read() for fields in result.fields]
            content[name] = (
                variable(name, ("x", "y"), values[0])
                if name == "heights"
                else variable(name, ("load", "x", "y"), np.stack(values))
            )
        scales = {"load": columns["p"], **axes(result.surface)}
        places = {name: variable(name, (name,), values) for name, values in scales.items()}
        return Dataset(content, places, result.facts)

    def plot(self, what: str | None = None, **how: Any) -> "Figure":
        """Draw a matplotlib figure, as `hpc-gfmd plot` does.

        Parameters
        ----------
        what : str, optional
            "curves" (over the loads; default for several), "maps" (default for one with fields),
            "distributions", "spectra", one field or one curve, such as "a_r".
        **how
            step (which loads), window, dpi, dimensionless, columns, ax (where to draw one panel);
            see `hpc_gfmd.plot`, which also draws several results together.

        Returns
        -------
        Figure
            Show it, or save it by its `savefig`.

        Raises
        ------
        SceneError
            For an unknown picture or keyword, or if the fields are spread over ranks.
        """
        from .plot import plot

        _, _, *keywords = signature(plot).parameters
        for name in how:
            require_known("plot", name, keywords)
        self._require_whole("plot")
        return plot(self.result, what or self._picture, **how)

    def _require_whole(self, action: str) -> None:
        """Raise SceneError if the fields are spread over ranks; `action` names what was called."""
        if self.comm.size > 1:
            raise SceneError(
                f"{action}: found fields that are spread over {self.comm.size} ranks, allowed:"
                " save, and load the file"
            )


def _number(name: str, value: float | str, dimension: str) -> float:
    """Return a plain number, or one with a unit in SI units. Raises SceneError for other texts."""
    if not isinstance(value, str):
        return value
    try:
        return float(parse(value, dimension))
    except ValueError as error:
        raise SceneError(
            f"{name}: found {value!r}, {error}, allowed: a number, or a text with a unit"
        ) from None
