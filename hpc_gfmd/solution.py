"""What a solved load says, in memory or from a result file: numbers, fields, and what else is asked of it."""

from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from .contact import FIELDS, Contact, LazyField
from .errors import SceneError
from .output.html import html_table
from .output.read import Result
from .output.record import RunFile
from .output.table import summary, surface_line
from .parallel.comm import SerialComm
from .registry import all_distributions, all_observables, distribution_names, names_together, observable_names
from .restored import LOST, restored_contact, whole
from .scene.explain import nearest

if TYPE_CHECKING:
    from .plotting.style import Figure


class Solution:
    """A solved load.

    Pressures are in the unit of E_star (Pa where `pressure_unit` is "Pa"), lengths in that of the heights (m where `unit` is "m").
    Fields have the shape of the heights, (n_x, n_y), or, where a communicator was given, are the rows of this rank: `rows`.

    result : output.read.Result
        All that is known, by the names of the result file: result.surface, result.steps[0], result.fields[0].
    """

    def __init__(self, result: Result, contact: Contact | None = None, rows: tuple[int, int] | None = None, comm: Any = None):
        self.result, self.comm, self._contact = result, comm or SerialComm(), contact
        self.rows = rows or (0, int(result.surface["n"][0]))
        self._arrays = {}

    # numbers

    @property
    def p(self) -> float:
        """Mean pressure over the nominal area, in the unit of E_star."""
        return self._step["p"]

    @property
    def p_star(self) -> float:
        """p/(E* g_rms), dimensionless; nan on a flat surface."""
        return self._step["p_star"]

    @property
    def a_r(self) -> float:
        """Relative contact area: points in contact over all points."""
        return self.observable("a_r")

    @property
    def a_r_edge(self) -> float | None:
        """a_r less what points on the edge of the contact count too much; None for profiles and for points that are not square."""
        return self.observable("a_r_corrected")

    @property
    def a_r_error(self) -> float:
        """Estimated relative error of a_r on this grid: the solver's."""
        return self._step["a_r_error"]

    @property
    def a_r_discretisation(self) -> float:
        """Estimated relative error of a_r by the size of a grid point."""
        return self._step["a_r_discretisation"]

    @property
    def kappa(self) -> float:
        """a_r/p_star; nan on a flat surface."""
        found = self.observable("kappa")
        return float("nan") if found is None else found

    @property
    def gap_mean(self) -> float:
        """Mean gap, in the unit of the heights."""
        return self.observable("gap_mean")

    @property
    def errors(self) -> tuple[float, float, float]:
        """Estimated relative errors, by the solver on this grid, of a_r, of the mean gap and of the pressure field (L2)."""
        return self._step["a_r_error"], self._step["gap_error"], self._step["pressure_error"]

    @property
    def g_rms(self) -> float:
        """Realised rms gradient of the heights."""
        return self.result.surface["g_rms"]

    @property
    def h_rms(self) -> float:
        """rms height."""
        return self.result.surface["h_rms"]

    @property
    def status(self) -> str:
        """"converged", "stagnated", "max_iterations", "nonfinite" or "interrupted"."""
        return self._step["status"]

    @property
    def iterations(self) -> int:
        """Iterations on the fine grid."""
        return self._step["iterations"]

    @property
    def fft_pairs(self) -> float:
        """FFT pairs of the fine grid, everything counted."""
        return self._step["fft_pairs"]

    @property
    def precision(self) -> str:
        """"float32" or "float64": in which it was solved."""
        return self._step["precision"]

    @property
    def note(self) -> str | None:
        """What limits the meaning of the numbers, such as too few points that touch."""
        return self._step.get("note")

    @property
    def sizes(self) -> tuple[float, float]:
        """(L_x, L_y) of the nominal area, in the unit of the heights."""
        return tuple(self.result.surface["physical_sizes"])

    @property
    def unit(self) -> str:
        """"m", or "" where nobody named the unit of length."""
        return self.result.surface.get("unit", "")

    @property
    def pressure_unit(self) -> str:
        """"Pa", or "" where nobody named the unit of pressure."""
        return self.result.surface.get("pressure_unit", "")

    # fields

    @property
    def pressure(self) -> np.ndarray:
        """Contact pressure (n_x, n_y), >= 0, and 0 where the gap is open."""
        return self._field("pressure")

    @property
    def gap(self) -> np.ndarray:
        """Gap between the deformed surface and the wall (n_x, n_y), >= 0: displacement - heights."""
        return self._field("gap")

    @property
    def displacement(self) -> np.ndarray:
        """Displacement of the elastic surface away from the wall (n_x, n_y): gap + heights."""
        return self._field("displacement")

    @property
    def heights(self) -> np.ndarray:
        """Heights of the wall (n_x, n_y), peaks up, measured from the highest: <= 0."""
        return self._field("heights")

    @property
    def contact(self) -> np.ndarray:
        """Where the surfaces touch, (n_x, n_y) of bool: pressure > 0."""
        return self.pressure > 0

    # on request

    def observable(self, name: str) -> Any:
        """A number by the name it has in the scene's output.observables, computed now if it was not asked for before.

        "stiffness", "perimeter", ...: the number (None where it has no value); "patches", "percolation": a dict of several.
        Collective. Raises SceneError for an unknown name, and where what is left of the contact does not tell it.
        """
        if name not in observable_names():
            raise SceneError(f'observable: found {name!r}, nearest: "{nearest(str(name), observable_names())}", '
                             f"allowed: {', '.join(sorted(observable_names()))}")
        several = names_together(name)
        for one in several or (name,):
            if one not in self._step:
                if self._contact is None and one in LOST:
                    raise SceneError(f"{one}: not in {self.result.path}, allowed: a run that has it in output.observables")
                self._step[one] = all_observables()[one](self._whole_contact())
        return {one: self._step[one] for one in several} if several else self._step[name]

    def distribution(self, name: str) -> dict[str, np.ndarray] | None:
        """Arrays by the name they have in the scene's output.distributions, computed now if they were not asked for before.

        "pressure", "gap", "patches": {"edges": (k + 1,), "density": (k,)}; "heights_spectrum": {"q", "power"}; ... None where there is
        nothing to count. Collective. Raises SceneError as `observable`.
        """
        free = [word == "free" for word in self.result.surface.get("boundary", "").split(", ")]
        if name not in distribution_names(free):
            raise SceneError(f'distribution: found {name!r}, nearest: "{nearest(str(name), distribution_names(free))}", '
                             f"allowed: {', '.join(sorted(distribution_names(free)))}")
        if not self._stored_distribution(name):
            contact = self._whole_contact()
            if name.startswith("heights") and contact.surface.h is None:
                raise SceneError(f'{name}: {self.result.path} has no heights, allowed: a result with fields = ["heights", ...]')
            found = all_distributions()[name](contact) or {}
            self._step.update({f"{name}_{what}": values.tolist() for what, values in found.items()})
        return self._stored_distribution(name) or None

    @property
    def observables(self) -> dict[str, float | None]:
        """The numbers that are known so far, by name; `observable` finds others."""
        return {name: self._step[name] for name in all_observables() if name in self._step}

    @property
    def distributions(self) -> dict[str, dict[str, np.ndarray]]:
        """The distributions that are known so far, by name; `distribution` finds others."""
        return {name: found for name in all_distributions() if (found := self._stored_distribution(name))}

    def save(self, path: str | PathLike, force: bool = False) -> Path:
        """Write a result file, as `hpc-gfmd run` does; see Solutions.save."""
        return _save(self, path, force)

    def plot(self, what: str | None = None, **how: Any) -> "Figure":
        """A matplotlib figure, as `hpc-gfmd plot` draws it: "maps" (default where fields are kept), "distributions", "spectra",
        "curves" or one field.

        how: window, dpi, dimensionless; see plotting.plot. Raises SceneError where there is no such picture, or fields are spread over
        ranks.
        """
        return _plot(self, what, how)

    def __repr__(self) -> str:
        return f"<Solution: {summary(self._step, self.result.surface)}>"

    def _repr_html_(self) -> str:
        return html_table(self.result.steps, self.result.surface, across=False)

    def __reduce__(self):
        return Solution, (_in_memory(self.result), None, self.rows)

    @property
    def _step(self) -> dict:
        return self.result.steps[0]

    def _field(self, name):
        if name not in self._arrays:
            stored = self.result.fields[0]
            if name in stored:
                self._arrays[name] = whole(stored[name])
            elif self._contact is not None and name in FIELDS:
                self._arrays[name] = np.asarray(self._contact.field(name))
            elif name == "displacement" and {"gap", "heights"} <= set(stored):
                self._arrays[name] = self.gap + self.heights
            else:
                where = f"in {self.result.path}" if self.result.path else "kept"
                raise SceneError(f'{name}: not {where}, allowed: fields = ["{name}", ...] where it is solved')
        return self._arrays[name]

    def _whole_contact(self):
        if self._contact is None:
            self._contact = restored_contact(self.result)
        return self._contact

    def _stored_distribution(self, name):
        named = {key.removeprefix(f"{name}_"): value for key, value in self._step.items() if key.startswith(f"{name}_")}
        return {what: np.array(value) for what, value in named.items() if isinstance(value, list) and "_" not in what}


class Solutions(Sequence):
    """The solutions of a sweep of loads, in the order of the loads.

    result : output.read.Result
        All that is known, by the names of the result file.
    """

    def __init__(self, solutions: Sequence[Solution], result: Result):
        self._all, self.result = list(solutions), result

    @overload
    def __getitem__(self, index: int) -> Solution: ...
    @overload
    def __getitem__(self, index: slice) -> "Solutions": ...
    def __getitem__(self, index):
        if not isinstance(index, slice):
            return self._all[index]
        picked = {key: getattr(self.result, key)[index] for key in ("steps", "indices", "fields")}
        return Solutions(self._all[index], replace(self.result, **picked))

    def __len__(self) -> int:
        return len(self._all)

    @property
    def status(self) -> str:
        """The worst of all loads; "interrupted" or "running" of a file that is not finished."""
        return self.result.status

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader should know, such as loads that are missing, a line each."""
        return self.result.notes

    def values(self, name: str) -> np.ndarray:
        """An observable or another number of all loads, (loads,), by its name in the result file: values("p_star"); nan for none."""
        found = [one.result.steps[0][name] if name in one.result.steps[0] else one.observable(name) for one in self]
        return np.array([np.nan if value is None else value for value in found])

    def save(self, path: str | PathLike, force: bool = False) -> Path:
        """Write a result file of all loads, as `hpc-gfmd run` does; returns its path.

        path: of the file, which ends in .h5; force: overwrite a file that is not a result of the same surface, loads and settings.
        Collective. Warns of what it replaces. Raises SceneError where it may not be written, GfmdError where writing fails.
        """
        return _save(self, path, force)

    def plot(self, what: str = "curves", **how: Any) -> "Figure":
        """A matplotlib figure, as `hpc-gfmd plot` draws it: "curves" (over the loads), "maps", "distributions", "spectra" or one field.

        how: step (which loads), window, dpi, dimensionless; see plotting.plot. Raises SceneError where there is no such picture, or
        fields are spread over ranks.
        """
        return _plot(self, what, how)

    def __repr__(self) -> str:
        lines = [f"<{len(self)} solution{'s' * (len(self) != 1)}: {surface_line(self.result.surface)}, {self.status}"]
        lines += [f"  {k}: {summary(step, self.result.surface)}" for k, step in zip(self.result.indices, self.result.steps)]
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)]) + ">"

    def _repr_html_(self) -> str:
        return html_table(self.result.steps, self.result.surface, self.result.indices, self.notes)

    def __reduce__(self):
        return solutions_of, (_in_memory(self.result),)


def solutions_of(result: Result, contacts=None, rows=None, comm=None) -> Solutions:
    """The Solutions of a Result; contacts: one contact.Contact, or None, for each load."""
    contacts = contacts or [None] * len(result.steps)
    singles = [replace(result, steps=[step], indices=[index], fields=[fields], status=step["status"])
               for step, index, fields in zip(result.steps, result.indices, result.fields, strict=True)]
    return Solutions([Solution(single, contact, rows, comm) for single, contact in zip(singles, contacts, strict=True)], result)


def _plot(solved, what, how):
    from .plotting import plot

    one = solved if isinstance(solved, Solution) else solved[0]
    if one.comm.size > 1:
        raise SceneError(f"plot: found fields that are spread over {one.comm.size} ranks, allowed: save, and plot the file")
    return plot(solved.result, what, **how)


def _save(solved, path, force):
    import warnings

    one = solved if isinstance(solved, Solution) else solved[0]
    result, path = solved.result, Path(path)
    if path.suffix.lower() not in (".h5", ".hdf5"):
        raise SceneError(f"path: found {str(path)!r}, allowed: a path that ends in .h5 or .hdf5")
    said, comm, (start, stop) = result.surface, one.comm, one.rows

    def slab(field):
        return LazyField(lambda i0, i1: field.read(start + i0, start + i1), (stop - start, said["n"][1]), field.stored)

    head = {name: value for name, value in result.head.items() if name not in ("status", "end_time", "io")}
    with RunFile(comm, path, said["n"], one.rows, head, said, force=force) as file:
        if comm.rank == 0:
            for note in file.notes:
                warnings.warn(note, stacklevel=3)
        if any("heights" in fields for fields in result.fields):
            file.write_heights(slab(next(fields["heights"] for fields in result.fields if "heights" in fields)))
        for index, step, fields in zip(range(len(result.steps)), result.steps, result.fields, strict=True):
            file.write_step(index, step, {name: slab(field) for name, field in fields.items() if name != "heights"})
        file.finish(result.status)
    return path


def _in_memory(result):
    """The Result without what refers to a solver or to a file."""
    from .parallel.h5 import Slab

    def copy(field):
        return Slab(whole(field), field.span[0], field.shape)

    return replace(result, fields=[{name: copy(field) for name, field in fields.items()} for fields in result.fields])
