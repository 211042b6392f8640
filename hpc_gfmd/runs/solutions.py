"""The solutions of a sweep of loads as a sequence, in memory or from a result file."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ..output.read import Result, read_result
from ..output.save import in_memory, save
from ..output.table import html_table, summary, surface_line
from .solution import Solution, draw

if TYPE_CHECKING:
    from ..plotting.style import Figure


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
    def __getitem__(self, index: int | slice) -> "Solution | Solutions":
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
        """An observable or another number of all loads, (loads,), by its name in the result file:
        values("p_star"); nan for none."""
        found = [
            one.result.steps[0][name] if name in one.result.steps[0] else one.observable(name)
            for one in self
        ]
        return np.array([np.nan if value is None else value for value in found])

    def save(self, path: str | PathLike, force: bool = False) -> Path:
        """Write a result file of all loads, as `hpc-gfmd run` does; returns its path.

        path: of the file, which ends in .h5; force: overwrite a file that is not a result of the
        same surface, loads and settings. Collective. Warns of what it replaces. Raises SceneError
        where it may not be written, GfmdError where writing fails.
        """
        return save(self.result, path, force, self[0].rows, self[0].comm)

    def plot(self, what: str = "curves", **how: Any) -> "Figure":
        """A matplotlib figure, as `hpc-gfmd plot` draws it: "curves" (over the loads), "maps",
        "distributions", "spectra" or one field.

        how: step (which loads), window, dpi, dimensionless; see plotting.plot. Raises SceneError
        where there is no such picture, or fields are spread over ranks.
        """
        return draw(self.result, self[0].comm, what, how)

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

    def __reduce__(self) -> tuple[Any, ...]:
        return solutions_of, (in_memory(self.result),)


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


def solutions_of(
    result: Result,
    contacts: Sequence[Any] | None = None,
    rows: tuple[int, int] | None = None,
    comm: Any = None,
) -> Solutions:
    """The Solutions of a Result; contacts: one contact.Contact, or None, for each load."""
    contacts = contacts or [None] * len(result.steps)
    singles = [
        replace(result, steps=[step], indices=[index], fields=[fields], status=step["status"])
        for step, index, fields in zip(result.steps, result.indices, result.fields, strict=True)
    ]
    return Solutions(
        [
            Solution(single, contact, rows, comm)
            for single, contact in zip(singles, contacts, strict=True)
        ],
        result,
    )


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
    return solutions_of(result)
