"""Choose the search that finds the mean pressure of a load; earlier loads help it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from .full_contact import ClosingSearch
from .load_quantities import OpeningSearch, search_for

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..scene import SolverTable
    from .load import Load
    from .search import LoadSearch
    from .working_surface import WorkingSurface

# An `opening_load` below which the search for a mean gap starts from full contact, over E* g_rms;
# full contact takes 0.3 to 20.
NEARLY_CLOSED = 0.2


class Searches:
    """Prepares each load of a sweep: its mean pressure, or the search for it.

    Parameters
    ----------
    settings : scene.SolverTable
        The table [solver] of a scene; only accuracy and residual are used.
    """

    def __init__(self, settings: SolverTable):
        self.tolerance: float = settings.tolerance
        self.is_accuracy = settings.accuracy is not None
        self._history: list[dict[str, float]] = []  # results of the last two loads

    def begin(self, load: Load, working: WorkingSurface) -> Load:
        """Return a copy of a load with its mean pressure, or with the search for it.

        Nothing is solved. Collective, as a search needs the statistics of the heights.

        Parameters
        ----------
        load : Load
            A load as the scene prescribes it; it is not changed.
        working : WorkingSurface
            The surface.

        Returns
        -------
        Load
            The copy. Its p0 is in the program's unit; for full contact without a search it is 1
            until `full_contact` replaces it.
        """
        if load.is_pressure:
            return replace(load, given_p0=load.value / working.pressure_unit)
        if load.closes and working.full_contact_is_known and not working.surface.grid.padded:
            return replace(load, given_p0=1.0)  # until the closed contact is known
        return replace(load, search=self._search_for(load, working))

    def _search_for(self, load: Load, working: WorkingSurface) -> LoadSearch:
        """Make the search for a load that is not a pressure: for full contact, for a gap next to
        it, or for an area, gap or approach by the results of earlier loads."""
        if load.closes:
            return ClosingSearch(self.tolerance)
        heights = working.heights
        surface = working.surface
        if load.quantity == "gap_mean" and working.model.hardness is None:
            opens = opening_load(load.value, working)
            if opens < NEARLY_CLOSED:
                return OpeningSearch(
                    load.value / surface.slope,
                    self.tolerance,
                    self.is_accuracy,
                    heights,
                    heights,
                    slope=OpeningSearch.usual,
                    opens=opens,
                )
        return search_for(
            load,
            surface,
            heights,
            self.tolerance,
            self.is_accuracy,
            self._history,
            working.hardness,
        )

    def remember(self, contact: Contact, working: WorkingSurface) -> None:
        """Store load, area, gap and approach of a solution, for the searches of later loads.

        Parameters
        ----------
        contact : Contact
            The solution.
        working : WorkingSurface
            The surface.
        """
        a = working.surface.grid.a
        solved = {
            "p0": contact.p_mean / working.pressure_unit,
            "a_r": contact.contact_points / contact.N,
            "gap_mean": contact.certificate.gap_mean * a,
            "approach": contact.certificate.approach * a,
        }
        self._history = [*self._history[-1:], solved]


def opening_load(gap_mean: float, working: WorkingSurface) -> float:
    """Return how far a load is below full contact if one open point alone makes a mean gap.

    Parameters
    ----------
    gap_mean : float
        The mean gap, in the surface's unit of length.
    working : WorkingSurface
        The surface.

    Returns
    -------
    float
        Difference of mean pressures, in the program's unit.
    """
    grid = working.surface.grid
    gap_of_point = gap_mean / working.surface.height_unit * grid.N
    return gap_of_point * float(working.model.body.near(grid)[0])
