"""A picture as a list of panels that can be drawn on any axes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Any

from ..util.errors import SceneError

COLUMN_WIDTH = 3.35  # inches, 85 mm: one column of a journal
Panel = Callable[[Any], None]  # draws on the axes


@dataclass(frozen=True)
class Page:
    """A picture as a list of panels, with their arrangement.

    Attributes
    ----------
    panels : sequence of callable
        Functions that draw on the axes they are given; row by row.
    columns : int
        Panels beside each other, at most; four panels of curves have two unless `arranged`.
    height : float
        Height of one row, in inches.
    width : float
        Width of the picture, in inches; a single column of curves has COLUMN_WIDTH.
    images : bool
        Whether panels are images: axes keep their aspect and share their ticks.
    arranged : bool
        Whether the user chose `columns`.
    """

    panels: Sequence[Panel]
    columns: int = 3
    height: float = 2.3
    width: float = 7.2
    images: bool = False
    arranged: bool = False

    def with_columns(self, columns: int) -> "Page":
        """Return a copy with this number of columns.

        Parameters
        ----------
        columns : int
            Panels beside each other; with 1 the width becomes COLUMN_WIDTH.

        Returns
        -------
        Page

        Raises
        ------
        SceneError
            If there are fewer panels than columns, or columns is not positive.
        """
        if not 1 <= columns <= len(self.panels):
            raise SceneError(
                f"columns: found {columns}, allowed: from 1 to {len(self.panels)}, as many panels"
            )
        width = COLUMN_WIDTH if columns == 1 else self.width
        return replace(self, columns=columns, width=width, arranged=True)

    def draw(self, fig: Any) -> None:
        """Set size and layout of an empty figure, add axes to it and draw all panels."""
        panels = self.panels
        images = self.images
        four = len(panels) == 4 and not images and not self.arranged
        columns = 2 if four else min(self.columns, len(panels))
        rows = -(-len(panels) // columns)
        width = self.width if images or columns > 1 else COLUMN_WIDTH
        fig.set_size_inches(width, self.height * rows + (0.5 if images else 0.85))
        if images:
            fig.set_layout_engine("compressed", hspace=0.01, wspace=0.01, h_pad=0.03)
        axes = fig.subplots(rows, columns, squeeze=False, sharex=images, sharey=images).flat
        for k, (ax, panel) in enumerate(zip_longest(axes, panels)):
            if panel is None:
                ax.set_axis_off()
                continue
            panel(ax)
            if images and k % columns:
                ax.set_ylabel("")
            if images and k + columns < len(panels):
                ax.set_xlabel("")
            elif images:
                ax.tick_params(labelbottom=True)
