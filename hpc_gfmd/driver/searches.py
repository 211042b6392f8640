"""Which search finds the mean pressure of a load, with what is known from the loads before."""

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

# Loads that open a single point, of E* g_rms, below which a mean gap is searched for from full
# contact: full contact takes 0.3 to 20.
NEARLY_CLOSED = 0.2


class Searches:
    """Begins the search for each load of a sweep.

    Parameters
    ----------
    settings : scene.SolverTable
        The accuracy that is asked for.
    """

    def __init__(self, settings: SolverTable):
        self.tolerance: float = settings.tolerance
        self.is_accuracy = settings.accuracy is not None
        self._history: list[dict[str, float]] = []  # what the last two loads gave

    def begin(self, load: Load, working: WorkingSurface) -> Load:
        """Give a load its mean pressure, or the search for it; solve nothing.

        Collective where a search needs the statistics of the heights.

        Parameters
        ----------
        load : Load
            As the scene asks for it.
        working : WorkingSurface
            The surface.

        Returns
        -------
        Load
            A copy that is ready to be solved.
        """
        if load.is_pressure:
            return replace(load, given_p0=load.value / working.pressure_unit)
        if load.closes and working.full_contact_is_known and not working.surface.grid.padded:
            return replace(load, given_p0=1.0)  # until the closed contact is known
        return replace(load, search=self._search_for(load, working))

    def _search_for(self, load: Load, working: WorkingSurface) -> LoadSearch:
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
        """Remember what a solved load gave, for the searches after it.

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
    """Return by how much a load is below that of full contact where a single point is open.

    Parameters
    ----------
    gap_mean : float
        The mean gap then, in the surface's unit of length.
    working : WorkingSurface
        The surface.

    Returns
    -------
    float
        Mean pressure, in the program's unit.
    """
    grid = working.surface.grid
    gap_of_point = gap_mean / working.surface.height_unit * grid.N
    return gap_of_point * float(working.model.body.near(grid)[0])
