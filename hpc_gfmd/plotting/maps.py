"""Maps of contact, pressure, gap and other fields, of the whole cell or of a window."""

from collections.abc import Sequence
from functools import cache, partial
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap, Normalize, PowerNorm

from ..output.summary import converged
from .context import FigureContext
from .page import Page
from .style import CONTACT_MAP, DPI, GROUND, PRESSURE_MAP, WARNING, WIDTH, YIELDED
from .survey import Survey, survey
from .units import Scale, good

FIELDS = {  # symbol, colours
    "contact": ("", CONTACT_MAP),
    "pressure": ("p", PRESSURE_MAP),
    "gap": ("g", "viridis"),
    "heights": ("z", "cividis"),
    "displacement": ("u", "viridis"),
    "plastic": ("d", "viridis"),
}
# a largest value that is more than this times the 99.5th percentile does not set the colours
SPIKY = 1.25


def maps(contexts: Sequence[FigureContext], names: list[str]) -> Page:
    """Return a page with a row for each load of one result and a column for each field.

    A single field has two columns of loads instead.

    Parameters
    ----------
    contexts : sequence of FigureContext
        Only the first is used.
    names : list of str
        Keys of FIELDS: "contact", "pressure", "gap", ...

    Returns
    -------
    Page
        Not drawn yet; fields are read when it is drawn, each load once.
    """
    context = contexts[0]
    x0, x1, y0, y1 = context.window
    aspect = (y1 - y0) / (x1 - x0)
    loads = range(len(context.result.steps))
    columns = min(2, len(loads)) if len(names) == 1 else len(names)
    width = 0.735 * WIDTH / max(columns, 2)
    pixels = max(16, int(width * (context.dpi or DPI)))

    @cache
    def surveyed(k: int) -> Survey:
        fields = context.result.fields[k]
        alone = {*names} <= {"heights", "displacement", "plastic"}
        needed = {*names} if alone else {*names, "pressure", "gap"}
        chosen = {n: fields[n] for n in needed & {*fields}}
        return survey(chosen, pixels, context.points, context.hardness)

    def panel(k: int, name: str, ax: Any) -> None:
        _field(ax, context, surveyed(k), name)
        if name != names[0]:
            ax.set_title(name if k == 0 else "", loc="right")
        elif name != "heights":
            step = context.result.steps[k]
            start = ", " if aspect < 2 else "\n"
            area = f"{start}$a_r = {step['a_r']:.3g}$" if good(step.get("a_r")) else ""
            colour = "black" if converged(step) else WARNING
            ax.set_title(context.name_of(k) + area, loc="left", color=colour)

    return Page(
        [partial(panel, k, name) for k in loads for name in names],
        columns,
        height=width * np.clip(aspect, 0.4, 2.4) + 0.34,
        width=WIDTH if columns > 1 else WIDTH / 2,
        images=True,
    )


def _mark_yielded(ax: Any, share: np.ndarray, extent: list[float]) -> None:
    """Colour the pixels in which at least half of the touching points yield, with a legend entry.

    share: of each pixel's touching points, those whose pressure is the hardness.
    """
    yielded = np.ma.masked_less(share, 0.5)
    if yielded.count():
        ax.imshow(
            yielded.T,
            ListedColormap([YIELDED]),
            origin="lower",
            extent=extent,
            interpolation="nearest",
        )
        ax.plot([], [], "s", color=YIELDED, label="yields (pressure = hardness)")


def _field(ax: Any, context: FigureContext, pixels: Survey, name: str) -> None:
    """Draw one field of a load on axes, with its colour bar (none for contact).

    pixels: means over pixels of all fields of this load.
    """
    symbol, colours = FIELDS[name]
    in_units = [pixels.largest[name], float(pixels.means[name].min())]
    scale = context.units.of(name, in_units) if symbol else Scale()
    values = pixels.means[name] / scale.unit
    largest = pixels.largest[name] / scale.unit
    clipped = False
    norm: Any = Normalize(values.min(), values.max())
    if name == "contact":
        values = np.ma.masked_equal(values, 0)
        norm = Normalize(0, 1)
    elif name == "pressure":
        ax.set_facecolor(GROUND)
        values = np.ma.masked_where(pixels.means["contact"] == 0, values)
        top = np.percentile(values.compressed(), 99.5) if values.count() else 1.0
        clipped = largest > SPIKY * top > 0
        norm = Normalize(0, top if clipped else largest)
    elif name == "gap":  # square root: most of what matters happens at small gaps
        values = np.ma.masked_where(pixels.means["contact"] >= 0.5, values)
        norm = PowerNorm(0.5, vmin=0, vmax=largest)
    if norm.vmin == norm.vmax:
        norm.vmax += 1
    extent = [edge / context.lengths.unit for edge in context.window]
    image = ax.imshow(
        values.T, colours, norm, origin="lower", extent=extent, interpolation="nearest"
    )
    if name in ("contact", "pressure") and "yielded" in pixels.means:
        _mark_yielded(ax, pixels.means["yielded"], extent)
    ax.tick_params(color="0.5")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter("{x:g}")
    ax.set(xlabel=context.lengths.label("x"), ylabel=context.lengths.label("y"))
    if name == "contact":
        return
    titled = clipped or isinstance(norm, PowerNorm)
    bar = ax.figure.colorbar(
        image,
        cax=ax.inset_axes([1.04, 0, 0.06, 0.95 if titled else 1]),
        extend="max" if clipped else "neither",
    )
    bar.set_label(scale.label(symbol))
    if isinstance(norm, PowerNorm):
        bar.ax.set_title("square root", fontsize=6.5, pad=2, loc="left")
    if clipped:
        bar.ax.set_title(f"max {largest:.3g}", fontsize=6.5, pad=2, loc="left")
