"""Solutions of several loads, in memory or from a result file."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Self, overload

import numpy as np

from ..output.read import read_result
from ..output.result import Result
from ..output.summary import FINE, last_held, pull_off_bracket, pull_off_line, summary, surface_line
from ..parallel.comm import Comm
from .solution import Solution
from .solved import Solved
from .table import html_table

if TYPE_CHECKING:
    from ..contact.contact import Contact


class Solutions(Solved, Sequence[Solution]):
    """The solutions of a sweep, a sequence of Solution in the order of the loads.

    Every number of the result is an array over the loads under its name, as `solutions.a_r`. A
    slice is again a Solutions.

    Attributes
    ----------
    p, p_star, a_r, a_r_error, a_r_discretisation, contact_area, contact_pressure_mean,
    contact_pressure_max, gap_mean, gap_error, pressure_error, fft_pairs : ndarray, shape (loads,)
        The numbers of that name of each Solution; nan for a load without a value.
    steps : list of dict
        The numbers of each load, by the names of the result file.
    status : str
        The worst status of all loads; "interrupted" or "running" if the run is not finished.
    path : Path or None
        The result file of `run` and `load`; None in memory.
    exit_code : int
        That of the command line: 0 if every load is converged, that of the signal if `run` was
        interrupted, otherwise 3.
    result : output.result.Result
        All numbers and fields, by the names of the result file. It is made when it is first read.
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
        steps: list[dict],
        make_result: Callable[[], Result],
        rows: tuple[int, int] | None = None,
        comm: Comm | None = None,
        *,
        status: str,
        contacts: "Sequence[Contact | None]" = (),
        path: Path | None = None,
        exit_code: int | None = None,
    ):
        """Made by `solve`, `run` and `load`.

        Parameters
        ----------
        steps : list of dict
            The numbers of each load, by the names of the result file.
        make_result : callable
            Makes all that a result file holds, when it is first looked at.
        rows, comm, contacts
            Rows (start, stop) of this rank; all ranks; solved loads in memory, None without fields.
        status : str
            The worst status of all loads, or that of the run.
        path : Path, optional
            The result file.
        exit_code : int, optional
            That of the command line; default: by the status.
        """
        make_result = cache(make_result)  # one for all loads, whichever of them asks
        super().__init__(steps, make_result, rows, comm)
        self.status = status
        self.path = path
        self.exit_code = exit_code or (0 if status in FINE else 3)
        contacts = contacts or [None] * len(steps)
        self._all = [
            Solution([step], partial(_only, make_result, k), rows, comm, contact)
            for k, (step, contact) in enumerate(zip(steps, contacts, strict=True))
        ]

    @classmethod
    def of(cls, result: Result) -> Self:
        """Return the solutions in a result that every process can read."""
        return cls(result.steps, lambda: result, status=result.status, path=result.path)

    @overload
    def __getitem__(self, index: int) -> Solution: ...
    @overload
    def __getitem__(self, index: slice) -> "Solutions": ...
    def __getitem__(self, index: int | slice) -> "Solution | Solutions":
        """Return the solution of one load, or for a slice a Solutions that shares its loads."""
        if not isinstance(index, slice):
            return self._all[index]
        chosen = Solutions(
            self.steps[index],
            lambda: self.result.some(index),
            self._rows,
            self.comm,
            status=self.status,
            path=self.path,
            exit_code=self.exit_code,
        )
        chosen._all = self._all[index]
        return chosen

    def __len__(self) -> int:
        return len(self._all)

    @property
    def converged(self) -> bool:
        """Whether all loads are finished and converged; surfaces that are apart count as that."""
        return self.status in FINE

    @property
    def pull_off(self) -> float | None:
        """Mean pressure of the last load before the bodies separate; None if none separates them.

        The pull-off load lies between it and the next load; at prescribed gaps or approaches it is
        the largest pull.
        """
        held = last_held(self.steps)
        return None if held is None else float(held["p"])

    @property
    def pull_off_force(self) -> float | None:
        """The force of `pull_off`: times the nominal area, in N where there are units."""
        pressure = self.pull_off
        sizes = self.result.surface["physical_sizes"]
        return None if pressure is None else pressure * float(sizes[0]) * float(sizes[1])

    @property
    def pull_off_bracket(self) -> tuple[float, float] | None:
        """Mean pressures of the last load that is held and the first that separates the bodies.

        None where `pull_off` is, and at prescribed gaps or approaches; pull_off_error= narrows it.
        """
        return pull_off_bracket(self.steps)

    def values(self, name: str) -> np.ndarray:
        """Return a number of all loads, shape (loads,); nan without a value. Collective."""
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
        pull_off = pull_off_line(self.steps, self.result.surface)
        lines += [f"  {pull_off}"] * bool(pull_off)
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)]) + ">"

    def _repr_html_(self) -> str:
        return html_table(self.result)


def _only(make_result: Callable[[], Result], k: int) -> Result:
    result = make_result()
    return result.some([k], status=result.steps[k]["status"])


class Interrupted(KeyboardInterrupt):
    """Ctrl-C after the first load of a sweep in memory; `solutions` are the finished loads. A
    notebook or the prompt has it as `sys.last_value`.
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
    """Open the solutions in a result file, or those of a run that is interrupted or running.

    Parameters
    ----------
    path
        A result file, or where an interrupted (or running) run would write it.

    Returns
    -------
    Solutions
        Even for a single load. Fields are read at first use. If loads are missing, `notes` and a
        warning tell which.

    Raises
    ------
    SceneError
        If there is no result, or the file is damaged, of another program or of another version.
    """
    result = read_result(path)
    if result.folder is not None:
        note = f"the run is {result.status}: {result.missing_loads}"
        result = replace(result, notes=(*result.notes, note))
        warnings.warn(f"{result.path}: {note}", stacklevel=2)
    return Solutions.of(result)
