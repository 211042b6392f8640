"""The solutions of several loads, in memory or from a result file."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ..output.read import read_result
from ..output.result import Result
from ..output.summary import last_held, summary, surface_line
from .solution import Solution
from .solved import Solved
from .table import html_table

if TYPE_CHECKING:
    from ..contact.contact import Contact


class Solutions(Solved, Sequence[Solution]):
    """The solutions of a sweep of loads, in the order of the loads.

    Every number of the result is an array over the loads under its name, as `solutions.a_r`.

    Attributes
    ----------
    p, p_star, a_r, a_r_error, a_r_discretisation, contact_area, contact_pressure_mean,
    contact_pressure_max, gap_mean, gap_error, pressure_error, fft_pairs : ndarray, shape (loads,)
        As of a Solution; nan where there is none.
    result : output.result.Result
        All that is known, by the names of the result file.
    """

    _picture = "curves"

    p: np.ndarray
    p_star: np.ndarray
    a_r: np.ndarray
    a_r_error: np.ndarray
    a_r_discretisation: np.ndarray
    contact_area: np.ndarray
    contact_pressure_mean: np.ndarray
    contact_pressure_max: np.ndarray
    gap_mean: np.ndarray
    gap_error: np.ndarray
    pressure_error: np.ndarray
    fft_pairs: np.ndarray

    def __init__(
        self,
        result: Result,
        rows: tuple[int, int] | None = None,
        comm: Any = None,
        contacts: "Sequence[Contact | None]" = (),
    ):
        """Made by `solve` and `load`.

        Parameters
        ----------
        result : output.result.Result
            Numbers and fields.
        rows : (int, int), optional
            Rows (start, stop) of this rank; default: all.
        comm : Comm, optional
            All ranks; default: this process alone.
        contacts : sequence of Contact or None, optional
            The solved loads in memory, None where no field was kept.
        """
        super().__init__(result, rows, comm)
        contacts = contacts or [None] * len(result.steps)
        self._all = [
            Solution(result.some([k], status=step["status"]), rows, comm, contact)
            for k, (step, contact) in enumerate(zip(result.steps, contacts, strict=True))
        ]

    @overload
    def __getitem__(self, index: int) -> Solution: ...
    @overload
    def __getitem__(self, index: slice) -> "Solutions": ...
    def __getitem__(self, index: int | slice) -> "Solution | Solutions":
        if not isinstance(index, slice):
            return self._all[index]
        chosen = Solutions(self.result.some(index), self.rows, self.comm)
        chosen._all = self._all[index]
        return chosen

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

    @property
    def pull_off(self) -> float | None:
        """The last mean pressure that the surfaces hold on a way to separation, in the unit of
        `p`: the load at which they come apart lies between it and the next one of the sweep.

        None in a sweep in which no load separates what touched at the load before.
        """
        held = last_held(self.result.steps)
        return None if held is None else float(held["p"])

    def values(self, name: str) -> np.ndarray:
        """Return an observable or another number of all loads, (loads,), by its name in the result
        file: values("p_star"); nan for none."""
        of_loads = [solution.value(name) for solution in self]
        return np.array([np.nan if value is None else value for value in of_loads])

    _get = values

    def __repr__(self) -> str:
        lines = [
            f"<{len(self)} solution{'s' * (len(self) != 1)}: {surface_line(self.result.surface)},"
            f" {self.status}"
        ]
        lines += [
            f"  {k}: {summary(step, self.result.surface)}"
            for k, step in self.result.numbered.items()
        ]
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)]) + ">"

    def _repr_html_(self) -> str:
        """Return the table of all loads for a notebook."""
        return html_table(self.result)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C in a sweep in memory, after its first load.

    Attributes
    ----------
    solutions : Solutions
        The loads that were finished. In a notebook or at the prompt, where this was not
        caught, it is `sys.last_value`.
    """

    def __init__(self, solutions: Solutions):
        super().__init__(
            f"{solutions.notes[-1]}; those finished are the `solutions` of this exception, "
            "hpc_gfmd.Interrupted (sys.last_value.solutions)"
        )
        self.solutions = solutions

    def __reduce__(self) -> tuple:
        return Interrupted, (self.solutions,)


def load(path: str | PathLike) -> Solutions:
    """Open the solutions in a result file, those of an interrupted run included.

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
