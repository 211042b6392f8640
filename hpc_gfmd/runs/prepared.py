"""A surface in memory, ready to be pressed, that remembers what was done to it."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..output.summary import surface_line

if TYPE_CHECKING:
    from ..plotting.style import Figure


@dataclass(frozen=True, eq=False)
class PreparedSurface:
    """A rough surface with its sizes and units, for `hpc_gfmd.solve`.

    Attributes
    ----------
    heights : ndarray, shape (n_x, n_y)
        Peaks up, float64, read-only (copy it to change it).
    sizes : (L_x, L_y)
        Physical sizes, in the unit of the heights.
    unit : str
        "m", or "" if the unit is unknown.
    prepared : tuple of str
        Operations on the heights so far, one line each.
    notes : tuple of str
        What may be wrong with the heights, one line each.
    free : (bool, bool)
        Whether the surface has free edges along x, along y; otherwise it is periodic.
    source : (dict, PreparedSurface) or None
        The scene's [surface] and the surface that it gave, for `table`.
    """

    heights: np.ndarray
    sizes: tuple[float, ...]
    unit: str = ""
    prepared: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    free: tuple[bool, bool] = (False, False)
    source: "tuple[dict[str, Any], PreparedSurface] | None" = field(default=None, repr=False)

    @property
    def table(self) -> dict[str, Any] | None:
        """The scene's [surface] that gives these heights; None in memory and after changes."""
        if self.source is None:
            return None
        table, made = self.source
        is_same = (made.sizes, made.unit, made.free) == (self.sizes, self.unit, self.free)
        return table if is_same and made.heights is self.heights else None

    def from_table(self, table: dict[str, Any]) -> "PreparedSurface":
        """Return a copy that remembers the keys `table` of the scene's [surface] it is from."""
        return replace(self, source=(table, self))

    @property
    def physical_sizes(self) -> tuple[float, ...]:
        """(L_x, L_y), by the name that the argument has."""
        return self.sizes

    @cached_property
    def h_rms(self) -> float:
        """Rms height, in the unit of the heights."""
        return float(np.std(self.heights))

    def plot(self, **how: Any) -> "Figure":
        """Draw the heights as a matplotlib figure; `how`: title, window and dpi of
        `plotting.maps.height_map`.
        """
        from ..plotting.maps import height_map

        return height_map(self.heights, self._attributes, **how)

    @property
    def _attributes(self) -> dict[str, Any]:
        return {
            "n": self.heights.shape,
            "physical_sizes": self.sizes,
            "h_rms": self.h_rms,
            "unit": self.unit,
        }

    def __repr__(self) -> str:
        edges = {(False, False): "periodic", (True, True): "free edges"}.get(
            self.free, f"free edges along {'xy'[self.free[1]]}"
        )
        parts = [surface_line(self._attributes), edges, *self.prepared]
        notes = f"; note: {'; '.join(self.notes)}" if self.notes else ""
        return f"<surface: {', '.join(parts)}{notes}>"
