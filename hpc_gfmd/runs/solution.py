"""A solved load, in memory or from a result file: numbers, fields, and what follows from them."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact import (
    all_distributions,
    all_numbers,
    all_observables,
    observable_names,
    observables_named,
    require_periodic,
)
from ..contact.response import DUALITY
from ..output.fields import FIELDS
from ..output.numbers import unit_of
from ..output.result import Result, missing_fields
from ..output.summary import converged, summary
from ..parallel.comm import Comm
from ..scene.explain import require_known
from ..util.errors import SceneError
from ..util.quantities import in_units
from .solved import Solved
from .table import html_table

if TYPE_CHECKING:
    from pandas import DataFrame

    from ..contact.contact import Contact

LOST = ("energy", "approach", *DUALITY)  # observables that the fields do not tell


def _field(name: str, about: str) -> Any:
    """Return a property of a Solution: the field of this name. `about` is its docstring."""
    return property(lambda solution: solution._field(name), doc=about)


class StoredDistribution(dict):
    """Arrays of a distribution by name, as a dict with units.

    Attributes
    ----------
    units : dict of str to str
        Unit of each array, as "Pa"; "" if the unit has no name.
    """

    units: dict[str, str]


class Solution(Solved):
    """A solved load.

    Every number of the result is an attribute of its name: `hpc-gfmd help observables` lists them.
    Pressures are in the unit of E_star (Pa if `pressure_unit` is "Pa"), lengths in that of the
    heights (m if `unit` is "m"). Fields have the shape of the heights, (n_x, n_y); with a
    communicator they are the rows of this rank, `rows`. Reading a field that was not kept raises
    SceneError, unless it follows from those that were.

    Attributes
    ----------
    p, p_star : float
        Mean pressure over the nominal area; p/(E* g_rms), nan on a flat surface.
    a_r, a_r_corrected : float
        Relative contact area: fraction of points in contact; the same with a correction for the
        edge of the contact (None for profiles and for points that are not square).
    a_r_error, a_r_discretisation : float
        Estimated relative errors of a_r: by the solver on this grid; by the size of a grid point.
    contact_area : float
        a_r times the nominal area.
    contact_pressure_mean, contact_pressure_max : float
        Mean pressure over the contact area (None if nothing touches); largest at a grid point.
    gap_mean : float
        Mean gap over the nominal area.
    p_error : float or None
        Estimated relative error of p where adhesion holds a prescribed gap or approach; else None.
    gap_error, pressure_error : float
        Estimated relative errors by the solver, of the mean gap and of the pressure field (L2).
    status : str
        "converged", "stagnated", "max_iterations", "nonfinite", "interrupted", or "separated" if
        the load pulls more than the attraction of the surfaces holds.
    iterations, fft_pairs : int, float
        Iterations on the finest grid; all FFT pairs, in pairs of the finest grid.
    residual : float
        Rms pressure where the gap is open, over the mean pressure.
    precision : str
        "float32" or "float64": that of the solution.
    result : output.result.Result
        All numbers and fields, by the names of the result file: result.surface, result.steps[0],
        result.fields[0]. It is made when it is first read.
    """

    p: float
    p_star: float
    a_r: float
    a_r_corrected: float | None
    a_r_error: float
    a_r_discretisation: float
    contact_area: float
    contact_pressure_mean: float | None
    contact_pressure_max: float
    gap_mean: float
    p_error: float | None
    gap_error: float
    pressure_error: float
    status: str
    iterations: int
    fft_pairs: float
    precision: str
    residual: float

    def __init__(
        self,
        steps: list[dict],
        make_result: Callable[[], Result],
        rows: tuple[int, int] | None = None,
        comm: Comm | None = None,
        contact: "Contact | None" = None,
    ):
        """Made by `solve` and `load`.

        Parameters
        ----------
        steps : list of dict
            The numbers of the load, by the names of the result file; one load.
        make_result : callable
            Makes all that a result file holds, when it is first looked at.
        rows, comm, contact
            Rows (start, stop) of this rank; all ranks; the solved load in memory.
        """
        super().__init__(steps, make_result, rows, comm)
        (self._step,) = steps
        self._contact = contact
        self._arrays: dict[str, np.ndarray] = {}

    @property
    def converged(self) -> bool:
        """Whether the load reached the required accuracy, or the surfaces are apart."""
        return converged(self._step)

    @property
    def kappa(self) -> float:
        """a_r/p_star; nan on a flat surface."""
        kappa = self.value("kappa")
        return float("nan") if kappa is None else kappa

    @property
    def errors(self) -> tuple[float, float, float]:
        """Estimated relative errors by the solver of a_r, mean gap and pressure field (L2)."""
        return self.a_r_error, self.gap_error, self.pressure_error

    @property
    def note(self) -> str | None:
        """What limits the meaning of the numbers, such as few points in contact, or None."""
        return self._step.get("note")

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
        "plastic",
        "Depth of the dents where the pressure is the hardness (n_x, n_y), >= 0; with load.history"
        " what this load has added.",
    )
    dent: np.ndarray = _field(
        "dent", "Depth of the dents of all loads so far (n_x, n_y), >= 0; with load.history."
    )
    heights: np.ndarray = _field(
        "heights",
        "Heights of the rigid surface (n_x, n_y), peaks up, measured from the highest: <= 0.",
    )

    @property
    def contact(self) -> np.ndarray:
        """Mask of the points in contact, (n_x, n_y) of bool; needs the pressure."""
        return self.pressure > 0

    def value(self, name: str) -> Any:
        """Return a number, text or list by its name in the result file, computed as by `observable`
        if it is not there; None if it has no value.
        """
        return self._step[name] if name in self._step else self.observable(name)

    _get = value

    def observable(self, name: str) -> Any:
        """Return an observable by its name in output.observables, computed if need be. Collective.

        A dict for a name that stands for several, such as "percolation"; None without a value.
        Raises SceneError for an unknown name, and without a contact in memory for energy, approach
        and error bounds, or if pressure and gap were not stored.
        """
        require_known("observable", name, observable_names())
        members = observables_named([name])
        for member, observable in members.items():
            if member not in self._step:
                if self._contact is None and member in LOST:
                    raise SceneError(
                        f"{member}: not in {self.result.path}, allowed: a run that has it in"
                        " output.observables"
                    )
                self._step[member] = observable(self._whole_contact)
        if name in self._step:
            return self._step[name]
        return {member: self._step[member] for member in members}

    def distribution(self, name: str) -> StoredDistribution | None:
        """Return a distribution by its name in output.distributions, computed if need be.
        Collective.

        "pressure", "gap", "patches": {"edges": (k + 1,), "density": (k,)}; "heights_spectrum":
        {"q", "power"}; ... with their `units`; None if no point contributes. Raises SceneError for
        an unknown name and where heights, pressure or gap are missing; spectra and autocorrelations
        need a surface without free edges.
        """
        require_known("distribution", name, all_distributions())
        if not self._stored_distribution(name):
            require_periodic([name], self.result.scene.surface.free, "distribution")
            contact = self._whole_contact
            if name.startswith("heights") and contact.surface.h is None:
                raise missing_fields(self.result, ["heights"])
            arrays = all_distributions()[name](contact) or {}
            self._step.update({f"{name}_{part}": array.tolist() for part, array in arrays.items()})
        return self._stored_distribution(name) or None

    @property
    def observables(self) -> dict[str, float | None]:
        """{name: value} of the observables of the result and of those computed since."""
        return {name: self._step[name] for name in all_observables() if name in self._step}

    @property
    def distributions(self) -> dict[str, StoredDistribution]:
        """{name: arrays} of the distributions of the result and of those computed since."""
        return {
            name: distribution
            for name in all_distributions()
            if (distribution := self._stored_distribution(name))
        }

    def patch_table(self) -> "DataFrame":
        """Return a pandas table of the contact patches, the largest first.

        Columns: area, load (the force on it), x and y (centre), perimeter, periodic (across an edge
        of the cell); `attrs["units"]`: {column: unit}. Raises SceneError if fields are spread over
        ranks.
        """
        from pandas import DataFrame

        from ..contact.patches import TABLE_UNITS, patch_table

        self._require_whole("patch_table")
        table = DataFrame(patch_table(self._whole_contact))
        surface = self.result.surface
        table.attrs["units"] = {name: in_units(unit, surface) for name, unit in TABLE_UNITS.items()}
        return table

    def __repr__(self) -> str:
        numbers = summary(self._step, self.result.surface)
        return f"<Solution: {'; note: '.join([numbers, *self.notes])}>"

    def _repr_html_(self) -> str:
        return html_table(self.result, across=False)

    def _field(self, name: str) -> np.ndarray:
        """Return a field, read or computed at the first call and then kept, or raise SceneError."""
        if name not in self._arrays:
            stored = self.result.fields[0]
            if name in stored:
                self._arrays[name] = stored[name].read()
            elif self._contact is not None and name in FIELDS:
                self._arrays[name] = np.asarray(self._contact.field(name))
            elif name == "displacement" and {"gap", "heights"} <= set(stored):
                self._arrays[name] = self.gap + self.heights
            else:
                raise missing_fields(self.result, [name])
        return self._arrays[name]

    @cached_property
    def _whole_contact(self) -> "Contact":
        """The contact in memory, or one restored from the stored pressure and gap."""
        from .restored import restored_contact

        return self._contact or restored_contact(self.result)

    def _stored_distribution(self, name: str) -> StoredDistribution:
        """Return the arrays of a distribution in the result, with units; empty if it has none."""
        keys = {part: f"{name}_{part}" for part in all_distributions()[name].units}
        stored = {part: key for part, key in keys.items() if key in self._step}
        arrays = StoredDistribution(
            {part: np.array(self._step[key]) for part, key in stored.items()}
        )
        arrays.units = {
            part: unit_of(key, self.result.surface, all_numbers()) for part, key in stored.items()
        }
        return arrays
