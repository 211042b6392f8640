"""What a solved load says, in memory or from a result file: numbers, fields, and what else is asked
of it."""

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact import (
    all_distributions,
    all_observables,
    distribution_names,
    names_together,
    observable_names,
    require_periodic,
)
from ..output.fields import FIELDS
from ..output.read import Result
from ..output.save import in_memory, save
from ..output.table import html_table, summary
from ..parallel.comm import SerialComm
from ..scene.explain import nearest
from ..util.errors import SceneError

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..plotting.style import Figure

LOST = ("energy", "approach", "duality_gap")  # observables that the fields do not tell


def draw(result: Result, comm: Any, what: str | None, how: dict[str, Any]) -> "Figure":
    """A figure by plotting.plot. Raises SceneError where fields are spread over ranks."""
    from ..plotting import plot

    if comm.size > 1:
        raise SceneError(
            f"plot: found fields that are spread over {comm.size} ranks, allowed: save, and plot"
            " the file"
        )
    return plot(result, what, **how)


def _require_known(what: str, name: str, known: set[str]) -> None:
    if name not in known:
        raise SceneError(
            f'{what}: found {name!r}, nearest: "{nearest(str(name), known)}", allowed:'
            f" {', '.join(sorted(known))}"
        )


class Solution:
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
        self.result, self.comm, self._contact = result, comm or SerialComm(), contact
        self.rows = rows or (0, int(result.surface["n"][0]))
        self._arrays: dict[str, np.ndarray] = {}

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
    def a_r_corrected(self) -> float | None:
        """a_r less what points on the edge of the contact count too much; None for profiles and for
        points that are not square."""
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
        """Estimated relative errors, by the solver on this grid, of a_r, of the mean gap and of the
        pressure field (L2)."""
        return self._step["a_r_error"], self._step["gap_error"], self._step["pressure_error"]

    @property
    def g_rms(self) -> float:
        """Realised rms gradient of the heights."""
        return self.result.surface["g_rms"]

    @property
    def h_rms(self) -> float:
        """Realised rms of the heights, in their unit."""
        return self.result.surface["h_rms"]

    @property
    def status(self) -> str:
        """ "converged", "stagnated", "max_iterations", "nonfinite" or "interrupted"."""
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
        """ "float32" or "float64": in which it was solved."""
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
        """ "m", or "" where nobody named the unit of length."""
        return self.result.surface.get("unit", "")

    @property
    def pressure_unit(self) -> str:
        """ "Pa", or "" where nobody named the unit of pressure."""
        return self.result.surface.get("pressure_unit", "")

    # fields

    @property
    def pressure(self) -> np.ndarray:
        """Contact pressure (n_x, n_y), >= 0, and 0 where the gap is open."""
        return self._field("pressure")

    @property
    def gap(self) -> np.ndarray:
        """Gap between the deformed surface and the wall (n_x, n_y), >= 0: displacement -
        heights."""
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

    def save(self, path: str | PathLike, force: bool = False) -> Path:
        """Write a result file, as `hpc-gfmd run` does; see Solutions.save."""
        return save(self.result, path, force, self.rows, self.comm)

    def plot(self, what: str | None = None, **how: Any) -> "Figure":
        """A matplotlib figure, as `hpc-gfmd plot` draws it: "maps" (default where fields are kept),
        "distributions", "spectra", "curves" or one field.

        how: window, dpi, dimensionless; see plotting.plot. Raises SceneError where there is no such
        picture, or fields are spread over ranks.
        """
        return draw(self.result, self.comm, what, how)

    def __repr__(self) -> str:
        return f"<Solution: {summary(self._step, self.result.surface)}>"

    def _repr_html_(self) -> str:
        return html_table(self.result.steps, self.result.surface, across=False)

    def __reduce__(self) -> tuple:
        return Solution, (in_memory(self.result), None, self.rows)

    @property
    def _step(self) -> dict:
        return self.result.steps[0]

    def _field(self, name: str) -> np.ndarray:
        if name not in self._arrays:
            stored = self.result.fields[0]
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
        named = {
            key.removeprefix(f"{name}_"): value
            for key, value in self._step.items()
            if key.startswith(f"{name}_")
        }
        return {
            what: np.array(value)
            for what, value in named.items()
            if isinstance(value, list) and "_" not in what
        }
