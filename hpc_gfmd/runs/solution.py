"""What solved loads say, in memory or from a result file: numbers, fields, and what else is asked
of them."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ..contact import (
    all_distributions,
    all_observables,
    distribution_names,
    names_together,
    observable_names,
    require_periodic,
)
from ..contact.duality import OBSERVABLES as OF_DUALITY
from ..output.fields import FIELDS
from ..output.read import Result, read_result
from ..output.save import in_memory, save
from ..output.summary import summary, surface_line
from ..parallel.comm import SerialComm
from ..scene.explain import nearest
from ..util.errors import SceneError
from .references import references_of
from .table import html_table

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..plotting.style import Figure

LOST = ("energy", "approach", *OF_DUALITY)  # observables that the fields do not tell


def _require_known(what: str, name: str, known: set[str]) -> None:
    if name not in known:
        raise SceneError(
            f'{what}: found {name!r}, nearest: "{nearest(str(name), known)}", allowed:'
            f" {', '.join(sorted(known))}"
        )


def _number(name: str, about: str) -> Any:
    """A property of a Solution: the number of this name in the result file."""
    return property(lambda solution: solution.value(name), doc=about)


def _field(name: str, about: str) -> Any:
    """A property of a Solution: the field of this name."""
    return property(lambda solution: solution._field(name), doc=about)


class _Solved:
    """What one solved load and several have in common; rows: of the fields, on this rank."""

    _picture: str | None = None

    def __init__(self, result: Result, rows: tuple[int, int] | None, comm: Any):
        self.result, self.comm = result, comm or SerialComm()
        self.rows = rows or (0, int(result.surface["n"][0]))

    def save(self, path: str | PathLike, force: bool = False) -> Path:
        """Write a result file, as `hpc-gfmd run` does; returns its path.

        path: of the file, which ends in .h5; force: overwrite a file that is not a result of the
        same surface, loads and settings, or an interrupted run. Collective. Warns of what it
        replaces. Raises SceneError where it may not be written, GfmdError where writing fails.
        """
        return save(self.result, path, force, self.rows, self.comm)

    def references(self) -> list[str]:
        """What to cite: the program and the papers behind these numbers, with DOI, a line each."""
        return references_of(self.result)

    def plot(self, what: str | None = None, **how: Any) -> "Figure":
        """A matplotlib figure, as `hpc-gfmd plot` draws it: "curves" (over the loads; default of
        several), "maps" (default of one whose fields are kept), "distributions", "spectra", one
        field or one curve, such as "a_r".

        how: step (which loads), window, dpi, dimensionless, ax (where to draw one panel); see
        hpc_gfmd.plot, which also draws several results together. Raises SceneError where there is
        no such picture, or fields are spread over ranks.
        """
        from ..plotting import plot

        if self.comm.size > 1:
            raise SceneError(
                f"plot: found fields that are spread over {self.comm.size} ranks, allowed: save,"
                " and plot the file"
            )
        return plot(self.result, what or self._picture, **how)


class Solution(_Solved):
    """A solved load.

    Pressures are in the unit of E_star (Pa where `pressure_unit` is "Pa"), lengths in that of the
    heights (m where `unit` is "m"). Fields have the shape of the heights, (n_x, n_y), or, where a
    communicator was given, are the rows of this rank: `rows`.

    result : output.read.Result
        All that is known, by the names of the result file: result.surface, result.steps[0],
        result.fields[0].
    """

    def __init__(
        self,
        result: Result,
        contact: "Contact | None" = None,
        rows: tuple[int, int] | None = None,
        comm: Any = None,
    ):
        super().__init__(result, rows, comm)
        self._contact = contact
        self._step, self._fields = result.steps[0], result.fields[0]
        self._arrays: dict[str, np.ndarray] = {}

    # numbers

    p: float = _number("p", "Mean pressure over the nominal area, in the unit of E_star.")
    p_star: float = _number("p_star", "p/(E* g_rms), dimensionless; nan on a flat surface.")
    a_r: float = _number("a_r", "Relative contact area: points in contact over all points.")
    a_r_corrected: float | None = _number(
        "a_r_corrected",
        "a_r less what points on the edge of the contact count too much; None for profiles and for"
        " points that are not square.",
    )
    a_r_error: float = _number(
        "a_r_error", "Estimated relative error of a_r on this grid: the solver's."
    )
    a_r_discretisation: float = _number(
        "a_r_discretisation", "Estimated relative error of a_r by the size of a grid point."
    )
    gap_mean: float = _number("gap_mean", "Mean gap, in the unit of the heights.")
    status: str = _number(
        "status", '"converged", "stagnated", "max_iterations", "nonfinite" or "interrupted".'
    )
    iterations: int = _number("iterations", "Iterations on the fine grid.")
    fft_pairs: float = _number("fft_pairs", "FFT pairs of the fine grid, everything counted.")
    precision: str = _number("precision", '"float32" or "float64": in which it was solved.')

    @property
    def kappa(self) -> float:
        """a_r/p_star; nan on a flat surface."""
        found = self.value("kappa")
        return float("nan") if found is None else found

    @property
    def errors(self) -> tuple[float, float, float]:
        """Estimated relative errors, by the solver on this grid, of a_r, of the mean gap and of the
        pressure field (L2)."""
        return self.a_r_error, self.value("gap_error"), self.value("pressure_error")

    @property
    def note(self) -> str | None:
        """What limits the meaning of the numbers, such as too few points that touch."""
        return self._step.get("note")

    @property
    def g_rms(self) -> float:
        """Realised rms gradient of the heights."""
        return self.result.surface["g_rms"]

    @property
    def h_rms(self) -> float:
        """Realised rms of the heights, in their unit."""
        return self.result.surface["h_rms"]

    @property
    def sizes(self) -> tuple[float, float]:
        """(L_x, L_y) of the nominal area, in the unit of the heights."""
        return tuple(self.result.surface["physical_sizes"])

    @property
    def unit(self) -> str:
        """ "m", or "" where nobody named the unit of length."""
        return self.result.surface.get("unit", "")

    @property
    def pressure_unit(self) -> str:
        """ "Pa", or "" where nobody named the unit of pressure."""
        return self.result.surface.get("pressure_unit", "")

    # fields

    pressure: np.ndarray = _field(
        "pressure", "Contact pressure (n_x, n_y), >= 0, and 0 where the gap is open."
    )
    gap: np.ndarray = _field(
        "gap",
        "Gap between the deformed and the rigid surface (n_x, n_y), >= 0: displacement - heights.",
    )
    displacement: np.ndarray = _field(
        "displacement",
        "Displacement of the elastic surface away from the rigid one (n_x, n_y): gap + heights.",
    )
    plastic: np.ndarray = _field(
        "plastic", "Depth of the dents where the pressure is the hardness (n_x, n_y), >= 0."
    )
    heights: np.ndarray = _field(
        "heights",
        "Heights of the rigid surface (n_x, n_y), peaks up, measured from the highest: <= 0.",
    )

    @property
    def contact(self) -> np.ndarray:
        """Where the surfaces touch, (n_x, n_y) of bool: pressure > 0."""
        return self.pressure > 0

    # on request

    def value(self, name: str) -> Any:
        """A number by its name in the result file, an `observable` or another one."""
        return self._step[name] if name in self._step else self.observable(name)

    def observable(self, name: str) -> Any:
        """A number by the name it has in the scene's output.observables, computed now if it was not
        asked for before.

        "stiffness", "patches", ...: the number (None where it has no value); "percolation" and
        other names of several: a dict. Collective. Raises SceneError for an unknown name, and
        where what is left of the contact does not tell it.
        """
        _require_known("observable", name, observable_names())
        several = names_together(name)
        for one in several or (name,):
            if one not in self._step:
                if self._contact is None and one in LOST:
                    raise SceneError(
                        f"{one}: not in {self.result.path}, allowed: a run that has it in"
                        " output.observables"
                    )
                self._step[one] = all_observables()[one](self._whole_contact())
        return self._step[name] if name in self._step else {one: self._step[one] for one in several}

    def distribution(self, name: str) -> dict[str, np.ndarray] | None:
        """Arrays by the name they have in the scene's output.distributions, computed now if they
        were not asked for before.

        "pressure", "gap", "patches": {"edges": (k + 1,), "density": (k,)}; "heights_spectrum":
        {"q", "power"}; ... None where there is nothing to count. Collective. Raises SceneError as
        `observable`.
        """
        along_x, _, along_y = self.result.surface.get("boundary", "").partition(", ")
        require_periodic([name], (along_x == "free", along_y == "free"), "distribution")
        _require_known("distribution", name, distribution_names())
        if not self._stored_distribution(name):
            contact = self._whole_contact()
            if name.startswith("heights") and contact.surface.h is None:
                raise SceneError(
                    f"{name}: {self.result.path} has no heights, allowed: a result with fields ="
                    ' ["heights", ...]'
                )
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
        return {
            name: found
            for name in all_distributions()
            if (found := self._stored_distribution(name))
        }

    def __repr__(self) -> str:
        return f"<Solution: {summary(self._step, self.result.surface)}>"

    def _repr_html_(self) -> str:
        return html_table(self.result.steps, self.result.surface, across=False)

    def __reduce__(self) -> tuple:
        return Solution, (in_memory(self.result), None, self.rows)

    def _field(self, name: str) -> np.ndarray:
        if name not in self._arrays:
            stored = self._fields
            if name in stored:
                self._arrays[name] = stored[name].read()
            elif self._contact is not None and name in FIELDS:
                self._arrays[name] = np.asarray(self._contact.field(name))
            elif name == "displacement" and {"gap", "heights"} <= set(stored):
                self._arrays[name] = self.gap + self.heights
            else:
                where = f"in {self.result.path}" if self.result.path else "kept"
                raise SceneError(
                    f'{name}: not {where}, allowed: fields = ["{name}", ...] where it is solved'
                )
        return self._arrays[name]

    def _whole_contact(self) -> "Contact":
        if self._contact is None:
            from .restored import restored_contact

            self._contact = restored_contact(self.result)
        return self._contact

    def _stored_distribution(self, name: str) -> dict[str, np.ndarray]:
        keys = {what: f"{name}_{what}" for what in all_distributions()[name].units}
        return {what: np.array(self._step[key]) for what, key in keys.items() if key in self._step}


class Solutions(_Solved, Sequence):
    """The solutions of a sweep of loads, in the order of the loads.

    result : output.read.Result
        All that is known, by the names of the result file.
    """

    _picture = "curves"

    def __init__(
        self,
        result: Result,
        contacts: "Sequence[Contact | None]" = (),
        rows: tuple[int, int] | None = None,
        comm: Any = None,
    ):
        super().__init__(result, rows, comm)
        contacts = contacts or [None] * len(result.steps)
        self._all = [
            Solution(_part(result, slice(k, k + 1), status=step["status"]), contact, rows, comm)
            for k, (step, contact) in enumerate(zip(result.steps, contacts, strict=True))
        ]

    @overload
    def __getitem__(self, index: int) -> Solution: ...
    @overload
    def __getitem__(self, index: slice) -> "Solutions": ...
    def __getitem__(self, index: int | slice) -> "Solution | Solutions":
        if not isinstance(index, slice):
            return self._all[index]
        some = Solutions(_part(self.result, index), (), self.rows, self.comm)
        some._all = self._all[index]
        return some

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
        """An observable or another number of all loads, (loads,), by its name in the result file:
        values("p_star"); nan for none."""
        found = [one.value(name) for one in self]
        return np.array([np.nan if value is None else value for value in found])

    def __repr__(self) -> str:
        lines = [
            f"<{len(self)} solution{'s' * (len(self) != 1)}: {surface_line(self.result.surface)},"
            f" {self.status}"
        ]
        lines += [
            f"  {k}: {summary(step, self.result.surface)}"
            for k, step in zip(self.result.indices, self.result.steps)
        ]
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)]) + ">"

    def _repr_html_(self) -> str:
        return html_table(self.result.steps, self.result.surface, self.result.indices, self.notes)

    def __reduce__(self) -> tuple:
        return Solutions, (in_memory(self.result), (), self.rows)


def _part(result: Result, some: slice, **other: Any) -> Result:
    """Some of its loads; other: what is said of them otherwise."""
    picked = {name: getattr(result, name)[some] for name in ("steps", "indices", "fields")}
    return replace(result, **picked, **other)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C in a sweep in memory, after its first load.

    Attributes
    ----------
    solutions : Solutions
        The loads that were finished. Where nobody caught this, in a notebook or at the prompt, it
        is `sys.last_value`.
    """

    def __init__(self, solutions: Solutions):
        super().__init__(
            f"{solutions.notes[-1]}; those finished are the `solutions` of this exception, "
            "hpc_gfmd.Interrupted (sys.last_value.solutions)"
        )
        self.solutions = solutions


def load(path: str | PathLike) -> Solutions:
    """The solutions in a result file, those of an interrupted run included.

    Parameters
    ----------
    path
        A result file, or where an interrupted (or running) run would write it.

    Returns
    -------
    Solutions
        Also of a single load. Fields are read when they are first asked for; `notes` and a warning
        tell which loads are missing.

    Raises
    ------
    SceneError
        If there is no result, or the file is damaged, foreign or of another version.
    """
    result = read_result(path)
    if result.folder is not None:
        note = f"the run is {result.status}: {result.missing_loads}"
        result = replace(result, notes=(*result.notes, note))
        warnings.warn(f"{result.path}: {note}", stacklevel=2)
    return Solutions(result)
