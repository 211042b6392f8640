"""How all pictures look: colours for the colour-blind, sizes of a journal of two columns."""

import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import Formatter, LogLocator, NullFormatter

from ..util.atomic import atomic_write
from ..util.notebook import in_notebook
from .view import tex_number

MARKERS = ("o", "s", "^", "D", "v", "P")
LINES: tuple[Any, ...] = (
    "-",
    (0, (5, 1.5)),
    (0, (1, 1)),
    (0, (5, 1, 1, 1)),
    (0, (3, 1, 1, 1, 1, 1)),
)
WARNING = "#D55E00"
THEORY: dict[str, Any] = {"color": "0.35", "linewidth": 1.2}
WIDTH = 7.2  # inches across two columns
COLUMN_WIDTH = 3.35  # inches, 85 mm: one column of a journal


def _part(name: str, low: float, high: float) -> LinearSegmentedColormap:
    """Return a new colour map: the part from low to high (0 to 1) of the one of this name."""
    part = matplotlib.colormaps[name](np.linspace(low, high, 256))
    return LinearSegmentedColormap.from_list(f"{name}_part", part)


# A single touching point must show on its ground, whatever its pressure.
CONTACT_MAP = _part("Greys", 0.5, 1.0)
PRESSURE_MAP = _part("magma_r", 0.22, 1.0)
GROUND = "0.93"  # where nothing touches
YIELDED = "#56B4E9"  # where the pressure is the hardness

RC: Any = matplotlib.rc_params_from_file(
    Path(__file__).with_name("journal.mplstyle"), use_default_template=False
)
DPI = RC["savefig.dpi"]
COLOURS = tuple(RC["axes.prop_cycle"].by_key()["color"])


class Picture(Figure):
    """A figure that a notebook shows, and that is saved at print resolution."""

    def savefig(self, *args: Any, **how: Any) -> None:
        """Save as matplotlib does, in the style of all pictures, at print resolution by default."""
        with styled():
            super().savefig(*args, **how)

    def _repr_png_(self) -> bytes:
        """Return the figure as a PNG at half the print resolution, for a notebook."""
        png = io.BytesIO()
        self.savefig(png, format="png", dpi=DPI / 2)
        return png.getvalue()

    def _ipython_display_(self) -> None:
        """Show the figure in a notebook, and close it in pyplot, which would show it again."""
        from IPython.display import display
        from matplotlib import pyplot

        pyplot.close(self)
        display({"image/png": self._repr_png_(), "text/plain": str(self)}, raw=True)


def new_picture() -> Picture:
    """Make an empty picture; in a notebook pyplot shows it at the end of the cell."""
    if in_notebook() and matplotlib.get_backend().endswith("inline"):
        from matplotlib import pyplot

        picture: Any = pyplot.figure(FigureClass=Picture, layout="constrained")
        return picture
    return Picture(layout="constrained")


def colour(k: int) -> str:
    """Return the colour of the k-th of several lines; colours repeat."""
    return COLOURS[k % len(COLOURS)]


def marker(k: int) -> str:
    """Return the marker of the k-th of several lines; not only colour tells them apart."""
    return MARKERS[k % len(MARKERS)]


def line(k: int) -> Any:
    """Return the line style of the k-th of several lines; not only colour tells them apart."""
    return LINES[k % len(LINES)]


class LogTicks(LogLocator):
    """Ticks of a logarithmic axis: decades, or 1, 3, or 1, 2, 5, ...: the first with three labels
    (two below 1e-3, where they are long).
    """

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Return the ticks between vmin and vmax, ascending; a few may lie beyond."""
        decades = np.asarray(super().tick_values(vmin, vmax))
        for digits in ([1], [1, 3], [1, 2, 5], [1, 2, 3, 5, 7]):
            ticks = np.kron(decades, digits)
            if np.count_nonzero((ticks >= vmin) & (ticks <= vmax)) >= (2 if vmin < 1e-3 else 3):
                break
        return ticks


class LogLabels(Formatter):
    """Labels of a logarithmic axis: plain numbers if all are short, otherwise powers of ten."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return self.format_ticks([x])[0]

    def format_ticks(self, values: Any) -> list[str]:
        """Return the labels of the ticks at these values."""
        plain = all(1e-3 <= x <= 1e4 for x in values)
        return [f"{x:g}" if plain else f"${tex_number(x, '.0e')}$" for x in values]


def log_axis(ax: Any, which: str) -> None:
    """Make the axis "x" or "y" logarithmic, with labels that do not overlap."""
    ax.set(**{f"{which}scale": "log"})
    axis = getattr(ax, f"{which}axis")
    axis.set_major_locator(LogTicks())
    axis.set_major_formatter(LogLabels())
    axis.set_minor_formatter(NullFormatter())


@dataclass(frozen=True)
class Page:
    """Panels, functions that draw on axes, and their arrangement (inches); images share ticks."""

    panels: Sequence[Callable[[Any], None]]
    columns: int | None = None
    height: float = 2.3
    width: float = WIDTH
    images: bool = False

    def draw(self, fig: Any) -> None:
        """Draw all panels on an empty figure, row by row."""
        number = len(self.panels)
        columns = self.columns or (2 if number == 4 else min(3, number))
        rows = -(-number // columns)
        images = self.images
        width = self.width if images or columns > 1 else COLUMN_WIDTH
        fig.set_size_inches(width, self.height * rows + (0.5 if images else 0.85))
        if images:
            fig.set_layout_engine("compressed", hspace=0.01, wspace=0.01, h_pad=0.03)
        axes = fig.subplots(rows, columns, squeeze=False, sharex=images, sharey=images).flat
        for k, (ax, panel) in enumerate(zip_longest(axes, self.panels)):
            if panel is None:
                ax.set_axis_off()
                continue
            panel(ax)
            if images and k % columns:
                ax.set_ylabel("")
            if images and k + columns < number:
                ax.set_xlabel("")
            elif images:
                ax.tick_params(labelbottom=True)


def legend(fig: Any, loc: str, columns: int = 1, fewest: int = 2) -> None:
    """Add one legend of all panels, each label once; none with fewer labels than `fewest`."""
    handles: dict[str, Any] = {}
    for ax in fig.axes:
        for handle, label in zip(*ax.get_legend_handles_labels()):
            handles.setdefault(label, handle)
    if len(handles) >= fewest:
        fig.legend(handles.values(), handles.keys(), loc=loc, ncols=columns)


@contextmanager
def styled() -> Iterator[None]:
    """Use the style of all pictures within this block; matplotlib's settings return at its end."""
    if in_notebook():
        from matplotlib import pyplot

        # loads its backend: what that sets up would be undone at the end of this block
        pyplot.draw_if_interactive()
    with matplotlib.rc_context(RC):
        yield


def save(fig: Any, path: Path, dpi: float | None = None) -> None:
    """Save a figure in the format of its suffix; the file is replaced once it is complete."""
    with atomic_write(path) as tmp:
        fig.savefig(tmp, format=path.suffix[1:].lower(), dpi=dpi)
