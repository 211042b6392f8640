"""How all pictures look: colours that colour-blind readers can tell apart, sizes as printed in a
journal of two columns."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..util.atomic import aside

# Okabe and Ito; the last one is kept for warnings
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#000000")
WARNING = "#D55E00"
THEORY: dict[str, Any] = {"color": "0.35", "linewidth": 1.2}
WIDTH = 7.2  # inches across two columns
DPI = 200


def _part(name: str, low: float, high: float) -> LinearSegmentedColormap:
    """A colour map without its ends."""
    whole = matplotlib.colormaps[name]
    return LinearSegmentedColormap.from_list(
        f"{name}_part", whole([low + (high - low) * k / 255 for k in range(256)])
    )


# A single touching point must show on its ground, whatever its pressure.
CONTACT_MAP, PRESSURE_MAP = _part("Greys", 0.5, 1.0), _part("magma_r", 0.22, 1.0)
GAP_MAP, HEIGHT_MAP, OTHER_MAP = "viridis", "cividis", "viridis"
GROUND = "0.93"  # where nothing touches

RC: Any = {
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "figure.titlesize": 8,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "axes.linewidth": 0.7,
    "lines.linewidth": 1.3,
    "lines.markersize": 4,
    "savefig.dpi": DPI,
    "savefig.bbox": "tight",
    "savefig.pad_inches": 0.04,
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}


class Picture(Figure):
    """A figure that a notebook shows, without pyplot."""

    def _repr_png_(self) -> bytes:
        with io.BytesIO() as png, styled():
            self.savefig(png, format="png")
            return png.getvalue()


def shade(x: float) -> Any:
    """A colour between dark blue (0) and yellow (1), for what varies evenly."""
    return matplotlib.colormaps["viridis"](x)


def ticks(axis: Any) -> None:
    """Of a logarithmic axis: a label for every decade; of hardly two decades, for 1, 2 and 5."""
    low, high = axis.get_view_interval()
    if high < 200 * low:
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def legend(fig: Any, loc: str, columns: int = 1) -> None:
    """One legend of all panels, each label once; columns: at most."""
    handles: dict[str, Any] = {}
    for ax in fig.axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    fig.legend(
        list(handles.values()), list(handles), loc=loc, ncols=min(columns, max(1, len(handles)))
    )


def legend_below(fig: Any) -> None:
    """The same, below the panels."""
    legend(fig, "outside lower center", 4)


@contextmanager
def styled() -> Iterator[None]:
    """Block in which everything drawn looks like this."""
    with matplotlib.rc_context(RC):
        yield


@contextmanager
def figure(path: Path, width: float, height: float) -> Iterator[Figure]:
    """`with figure(path, width, height) as fig`: drawn by Agg and saved under path; inches."""
    with styled():
        fig = Picture(figsize=(width, height), layout="constrained")
        yield fig
        save(fig, path)


def save(fig: Any, path: Path, dpi: float | None = None) -> None:
    """Under path in one move, in the format that its suffix names; dpi: default that of RC."""
    with styled(), aside(path) as tmp:
        fig.savefig(tmp, format=path.suffix[1:].lower(), dpi=dpi or RC["savefig.dpi"])
