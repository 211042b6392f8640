"""Contact, pressure, gap and other fields over the cell or a window of it, one row of panels per
load step."""

from functools import cache, partial
from typing import Any

import numpy as np
from matplotlib.colors import Normalize, PowerNorm

from ..output.summary import converged
from .context import FigureContext
from .page import Page
from .style import (
    CONTACT_MAP,
    DPI,
    GAP_MAP,
    GROUND,
    HEIGHT_MAP,
    OTHER_MAP,
    PRESSURE_MAP,
    WARNING,
    WIDTH,
)
from .survey import Survey, survey
from .units import good

SYMBOLS = {"pressure": "p", "gap": "g", "heights": "z", "displacement": "u", "plastic": "d"}
COLOURS = {"pressure": PRESSURE_MAP, "gap": GAP_MAP, "heights": HEIGHT_MAP}
# a largest value that is more than this times the 99.5th percentile does not set the colours
SPIKY = 1.25


def maps(context: FigureContext, names: list[str]) -> Page:
    """Make a row for each load, a column for each of `names`: "contact" or a field."""
    x0, x1, y0, y1 = context.window
    loads, single = range(len(context.chosen)), len(names) == 1
    columns = min(2, len(loads)) if single else len(names)
    width = 0.245 * WIDTH * 3 / max(columns, 2)
    pixels = max(16, int(width * (context.dpi or DPI)))

    @cache
    def found(k: int) -> Survey:
        fields = context.fields(k)
        alone = {*names} <= {"heights", "displacement", "plastic"}
        needed = {*names} if alone else {*names, "pressure", "gap"}
        return survey({n: fields[n] for n in needed & {*fields}}, pixels, context.points)

    panels = [
        partial(_panel, context=context, found=found, k=k, name=name, first=names[0])
        for k in loads
        for name in names
    ]
    shape = min(2.4, max(0.4, (y1 - y0) / (x1 - x0)))  # of a panel, height over width
    return Page(
        [panels[i : i + columns] for i in range(0, len(panels), columns)],
        height=width * shape + 0.34,
        width=WIDTH if columns > 1 else WIDTH / 2,
        images=True,
    )


def _panel(ax: Any, context: FigureContext, found: Any, k: int, name: str, first: str) -> None:
    ax.set_aspect("equal")
    ax.tick_params(color="0.5")
    if name == "contact":
        share = np.ma.masked_equal(found(k).means["contact"], 0)
        _show(ax, context, share, CONTACT_MAP, Normalize(0, 1))
    else:
        _field(ax, context, found(k), name)
    ax.set_xlabel(context.lengths.label("x"))
    ax.set_ylabel(context.lengths.label("y"))
    if name != first:
        ax.set_title(name if k == 0 else "", loc="right")
    elif name != "heights":
        step = context.steps[k]
        area = f", $a_r = {step['a_r']:.3g}$" if good(step.get("a_r")) else ""
        colour = "black" if converged(step) else WARNING
        ax.set_title(context.name_of(k) + area, loc="left", color=colour)


def _field(ax: Any, context: FigureContext, found: Survey, name: str) -> None:
    values, largest = found.means[name], found.largest[name]
    scale = context.units.of(name, [largest, float(values.min())])
    values, largest = values / scale.unit, largest / scale.unit
    clipped = False
    if name == "pressure":
        ax.set_facecolor(GROUND)
        values = np.ma.masked_where(found.means["contact"] == 0, values)
        top = np.percentile(values.compressed(), 99.5) if values.count() else 1.0
        clipped = largest > SPIKY * top > 0
        norm = Normalize(0, top if clipped else largest if largest > 0 else 1.0)
    elif name == "gap":  # square root: most of what matters happens at small gaps
        values = np.ma.masked_where(found.means["contact"] >= 0.5, values)
        norm = PowerNorm(0.5, vmin=0, vmax=max(largest, 1e-300))
    else:
        norm = Normalize(values.min(), values.max())
    image = _show(ax, context, values, COLOURS.get(name, OTHER_MAP), norm)
    bar = ax.figure.colorbar(
        image,
        cax=ax.inset_axes([1.04, 0, 0.06, 0.95 if clipped else 1]),
        extend="max" if clipped else "neither",
    )
    bar.set_label(scale.label(SYMBOLS[name]))
    if clipped:
        bar.ax.set_title(f"max {largest:.3g}", fontsize=6.5, pad=2, loc="left")


def _show(ax: Any, context: FigureContext, values: Any, colours: Any, norm: Any) -> Any:
    extent = [edge / context.lengths.unit for edge in context.window]
    return ax.imshow(
        values.T, origin="lower", extent=extent, interpolation="nearest", cmap=colours, norm=norm
    )
