"""How all pictures look.

Colour-blind readers can tell the colours apart; sizes are those of a journal of two columns.
"""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import Formatter, LogLocator, NullFormatter

from ..util.atomic import atomic_write
from ..util.notebook import in_notebook
from .units import tex_number

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
        """Save the figure in the style of all pictures, at print resolution unless `dpi` is given.

        Parameters
        ----------
        *args, **how
            What matplotlib's Figure.savefig takes.
        """
        with styled():
            super().savefig(*args, **how)

    def _repr_png_(self) -> bytes:
        """Return the figure as a PNG at half the print resolution, for a notebook."""
        png = io.BytesIO()
        self.savefig(png, format="png", dpi=DPI / 2)
        return png.getvalue()

    def _ipython_display_(self) -> None:
        """Show the figure in a notebook.

        It is closed in pyplot, which would show it again at the end of the cell.
        """
        from IPython.display import display
        from matplotlib import pyplot

        pyplot.close(self)
        display({"image/png": self._repr_png_(), "text/plain": str(self)}, raw=True)


def new_picture() -> Picture:
    """Make an empty picture.

    In a notebook pyplot registers it, and shows it at the end of the cell if it was not shown
    before.

    Returns
    -------
    Picture
    """
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


def shade(x: float) -> Any:
    """Return a colour between dark blue (x = 0) and yellow (x = 1), for an ordered series."""
    return matplotlib.colormaps["viridis"](x)


class LogTicks(LogLocator):
    """Ticks of a logarithmic axis: decades, or 1 and 3 of each, or 1, 2 and 5, ...

    It is the first of these that gives three labels, or two below 1e-3, where labels are long.
    """

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Return the ticks of an axis.

        Parameters
        ----------
        vmin, vmax : float
            Ends of the axis.

        Returns
        -------
        ndarray
            Ascending; a few may lie beyond the ends.
        """
        decades = np.asarray(super().tick_values(vmin, vmax))
        for digits in ([1], [1, 3], [1, 2, 5], [1, 2, 3, 5, 7]):
            ticks = np.kron(decades, digits)
            if np.count_nonzero((ticks >= vmin) & (ticks <= vmax)) >= (2 if vmin < 1e-3 else 3):
                break
        return ticks


class LogLabels(Formatter):
    """Labels of a logarithmic axis: plain numbers if all are short, otherwise powers of ten."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of the tick at x; pos is not used."""
        return self.format_ticks([x])[0]

    def format_ticks(self, values: Any) -> list[str]:
        """Return the labels of the ticks at these values."""
        plain = all(1e-3 <= x <= 1e4 for x in values)
        return [f"{x:g}" if plain else f"${tex_number(x, '.0e')}$" for x in values]


def log_axis(ax: Any, which: str) -> None:
    """Make an axis logarithmic, with labels that do not overlap.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Changed.
    which : {"x", "y"}
    """
    ax.set(**{f"{which}scale": "log"})
    axis = getattr(ax, f"{which}axis")
    axis.set_major_locator(LogTicks())
    axis.set_major_formatter(LogLabels())
    axis.set_minor_formatter(NullFormatter())


def legend(fig: Any, loc: str, columns: int = 1) -> None:
    """Add one legend of all panels to a figure, each label once; none if there are no labels.

    Parameters
    ----------
    fig : matplotlib.figure.Figure
    loc : str
        Position of the legend, as matplotlib takes it.
    columns : int
        Number of columns.
    """
    handles: dict[str, Any] = {}
    for ax in fig.axes:
        for handle, label in zip(*ax.get_legend_handles_labels()):
            handles.setdefault(label, handle)
    if handles:
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


@contextmanager
def figure(path: Path, width: float, height: float) -> Iterator[Figure]:
    """Yield a new figure in the style of all pictures, and save it at the end of the block.

    It is not saved if the block raises.

    Parameters
    ----------
    path : Path
        File to write, replaced if it exists.
    width, height : float
        In inches.
    """
    with styled():
        fig = Picture(figsize=(width, height), layout="constrained")
        yield fig
        save(fig, path)


def save(fig: Any, path: Path, dpi: float | None = None) -> None:
    """Save a figure; the file at path is replaced only once the new one is complete.

    Parameters
    ----------
    fig : matplotlib.figure.Figure
    path : Path
        Its suffix is the format.
    dpi : float, optional
        Default: print resolution.
    """
    with atomic_write(path) as tmp:
        fig.savefig(tmp, format=path.suffix[1:].lower(), dpi=dpi)
