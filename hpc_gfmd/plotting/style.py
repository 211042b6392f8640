"""How all pictures look: colours for the colour-blind, sizes of a journal of two columns, labels of
axes with their units. Those have SI prefixes, or a result without units is drawn dimensionless.
"""

import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
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

from ..output.result import Result
from ..output.summary import converged, is_positive
from ..util.atomic import atomic_write
from ..util.notebook import in_notebook
from ..util.quantities import prefixed

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


def tex_number(x: float, form: str = ".3g") -> str:
    """Return a number in this format as TeX, with an exponent as a power of ten."""
    mantissa, _, exponent = f"{x:{form}}".partition("e")
    factor = "" if mantissa == "1" else rf"{mantissa} \cdot "
    return f"{factor}10^{{{int(exponent)}}}" if exponent else mantissa


@dataclass(frozen=True)
class Scale:
    """A unit that divides numbers, and its name: "MPa", if `relative` as "E^* g", or ""."""

    unit: float = 1.0
    name: str = ""
    relative: bool = False

    def label(self, symbol: str, power: int = 1) -> str:
        """Return the label of an axis, such as "$p$ (MPa)" or "$p/E^*$"; the symbol is in TeX."""
        return label(symbol, (self, power))

    def value(self, symbol: str, number: float) -> str:
        """Return a number as "$p = 20$ MPa" or, of a relative unit, "$p/E^* = 0.2$"."""
        name = "" if self.relative else self.name
        left = label(symbol, (self, 1)).split("$")[1]
        return f"${left} = {tex_number(number / self.unit)}$ {name}".rstrip()


def label(symbol: str, *scales: tuple[Scale, int]) -> str:
    """Return the label of an axis for factors of its unit: "$P(p)$ (MPa$^{-1}$)", "$q L_x$"."""
    above: list[str] = []
    below: list[str] = []
    units: list[str] = []
    for scale, power in scales:
        formula = f"({scale.name})" if " " in scale.name else f"{{{scale.name}}}"
        if scale.relative:
            raised = formula + (f"^{{{abs(power)}}}" if abs(power) > 1 else "")
            (below if power > 0 else above).append(raised)
        elif scale.name:
            units.append(scale.name + (f"$^{{{power}}}$" if power != 1 else ""))
    divisor = " ".join(below) if len(below) < 2 else f"({' '.join(below)})"
    formula = r" \, ".join([symbol, *above]) + (f"/{divisor}" if below else "")
    return f"${formula}$" + (f" ({' '.join(units)})" if units else "")


class Units:
    """The scales of a result: units with SI prefixes if it has units, otherwise relative ones.
    `height`: what heights without a unit are divided by, and its name (default: h_rms); `rough`:
    pressures scale with E* g_rms; `lengths`: the scale of positions.
    """

    def __init__(
        self,
        surface: Mapping[str, Any],
        steps: Iterable[Mapping[str, Any]] = (),
        height: tuple[float, str] | None = None,
        dimensionless: bool = False,
    ) -> None:
        length, pressure = (
            "" if dimensionless else surface.get(unit, "") for unit in ("unit", "pressure_unit")
        )
        self.size = surface.get("physical_sizes", (1.0, 1.0))[0]
        self.rough = surface.get("kind", "self-affine") not in ("wave", "sphere")
        height = height or (surface.get("h_rms") or 0.0, r"h_\mathrm{rms}")
        slope = surface.get("g_rms")
        unit = (
            step["p"] / step["p_star"] / (1.0 if self.rough else slope)
            for step in steps
            if is_positive(slope) and is_positive(step.get("p_star")) and is_positive(step.get("p"))
        )
        name = r"E^* g_\mathrm{rms}" if self.rough else "E^*"
        self._scales = {
            "length": (length, Scale(self.size, "L_x", True)),
            "pressure": (pressure, Scale(next(unit, 0.0), name, True)),
            "height": (length, Scale(*height, True)),
            "force": ("N" if length and pressure else "", Scale(0.0, "", True)),
        }
        self.lengths = self.of("length", surface.get("physical_sizes", (1.0, 1.0)))

    def of(self, name: str, values: Iterable[Any]) -> Scale:
        """Return the scale of "length", "pressure", "force" or heights, prefixed for the values."""
        unit, relative = self._scales.get(name, self._scales["height"])
        if unit:
            factor, name = prefixed(values, unit)
            return Scale(factor, name.replace("u", "µ"))
        return relative if is_positive(relative.unit) else Scale()


def load_label(result: Result, k: int, units: Units) -> str:
    """Return the label of result.steps[k]: number, load, and a mark if not converged."""
    step = result.steps[k]
    name = f"step {result.indices[k]}"
    pressures = units.of("pressure", [step.get("p")])
    if units.rough and pressures.relative and is_positive(step.get("p_star")):
        name += f": $p^* = {step['p_star']:.3g}$"
    elif is_positive(step.get("p")):
        name += f": {pressures.value('p_0', step['p'])}"
    doubt = f"\nNOT CONVERGED ({step.get('status', 'unknown')})"
    return name + ("" if converged(step) else doubt)


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

    def picture(self, title: str) -> Picture:
        """Draw all panels, row by row, as a new picture with one legend."""
        with styled():
            fig = new_picture()
            self._draw(fig)
            narrow = fig.get_figwidth() <= COLUMN_WIDTH
            fewest = 1 if self.images else 2
            legend(fig, "outside lower center", columns=1 if narrow else 4, fewest=fewest)
            if title:
                fig.suptitle(title, x=0.01, ha="left", wrap=True)
        return fig

    def _draw(self, fig: Any) -> None:
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
