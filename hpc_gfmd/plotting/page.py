"""A picture as a table of panels, each of which can draw itself on any axes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

Panel = Callable[[Any], None]  # draws on the axes


@dataclass(frozen=True)
class Page:
    """rows: of panels; width, height: of the picture, without what stands above and below it, and
    of one row, in inches; images: whether axes keep their aspect and share their ticks."""

    rows: Sequence[Sequence[Panel]]
    height: float
    width: float = 7.2
    images: bool = False

    @property
    def panels(self) -> list[Panel]:
        """List all panels."""
        return [panel for row in self.rows for panel in row]

    @property
    def layout(self) -> Literal["compressed", "constrained"]:
        """Name the layout engine that a figure of this page needs."""
        return "compressed" if self.images else "constrained"

    def draw(self, fig: Any) -> None:
        """Draw all panels."""
        columns = max(len(row) for row in self.rows)
        below = 0.5 if self.images else 0.85
        fig.set_size_inches(self.width, self.height * len(self.rows) + below)
        if self.images:
            fig.get_layout_engine().set(hspace=0.01, wspace=0.01, h_pad=0.03)
        axes = fig.subplots(
            len(self.rows), columns, squeeze=False, sharex=self.images, sharey=self.images
        )
        for line, row, next_row in zip(axes, self.rows, [*self.rows[1:], ()], strict=True):
            for k, ax in enumerate(line):
                if k >= len(row):
                    ax.set_axis_off()
                    continue
                row[k](ax)
                if self.images and k:
                    ax.set_ylabel("")
                if self.images and k < len(next_row):
                    ax.set_xlabel("")
                elif self.images:
                    ax.tick_params(labelbottom=True)
