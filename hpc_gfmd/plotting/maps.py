"""Contact, pressure, gap and other fields over the cell or a window of it, one row of panels per
load step."""

from typing import Any

import numpy as np
from matplotlib.colors import Normalize, PowerNorm

from ..output.table import converged
from .drawn import Drawn
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
from .survey import survey
from .units import good

SYMBOLS = {"pressure": "p", "gap": "g", "heights": "z", "displacement": "u"}
COLOURS = {"pressure": PRESSURE_MAP, "gap": GAP_MAP, "heights": HEIGHT_MAP}
# a largest value that is more than this times the 99.5th percentile does not set the colours
SPIKY = 1.25
TALL, FLAT = 2.4, 0.4  # of panels, height over width


def maps(fig: Any, drawn: Drawn, names: list[str]) -> None:
    """A row for each load, a column for each of `names`: "contact" or a field. drawn:
    drawn.Drawn."""
    width, height = (window[1] - window[0] for window in (drawn.window[:2], drawn.window[2:]))
    single = len(names) == 1
    columns = min(2, len(drawn.chosen)) if single else len(names)
    rows = -(-len(drawn.chosen) // columns) if single else len(drawn.chosen)
    panel = 0.245 * WIDTH * 3 / max(columns, 2)
    fig.set_size_inches(
        WIDTH if columns > 1 else WIDTH / 2,
        rows * (panel * min(TALL, max(FLAT, height / width)) + 0.34) + 0.85,
    )
    fig.get_layout_engine().set(hspace=0.01, wspace=0.01, h_pad=0.03)
    axes = fig.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    pixels = max(16, int(panel * (drawn.dpi or DPI)))
    for k in range(len(drawn.chosen)):
        needed = {n for n in names if n != "contact"} | (
            {"pressure", "gap"} if {"contact", "pressure", "gap"} & set(names) else set()
        )
        fields = {name: field for name, field in drawn.fields(k).items() if name in needed}
        found = survey(fields, pixels, drawn.points)
        row = axes.flat[k : k + 1] if single else axes[k]
        for ax, name in zip(row, names, strict=True):
            _panel(fig, ax, name, found, drawn)
            if k == 0 and name != names[0]:
                ax.set_title(name)
        if names != ["heights"]:
            _heading(row[0], drawn, k)
    for ax in axes.flat[len(drawn.chosen) * (1 if single else columns) :]:
        ax.set_axis_off()
    for ax in axes[-1]:
        ax.set_xlabel(drawn.lengths.label("x"))
    for ax in axes[:, 0]:
        ax.set_ylabel(drawn.lengths.label("y"))


def _heading(ax: Any, drawn: Drawn, k: int) -> None:
    step = drawn.result.steps[drawn.chosen[k]]
    ax.annotate(
        drawn.name_of(k)
        + (f", $a_r = {step['a_r']:.3g}$" if good(step.get("a_r")) else "")
        + ("" if converged(step) else f", NOT CONVERGED ({step.get('status', 'unknown')})"),
        (0, 1),
        (0, 4),
        xycoords="axes fraction",
        textcoords="offset points",
        color="black" if converged(step) else WARNING,
        annotation_clip=False,
    )


def _panel(fig: Any, ax: Any, name: str, found: Any, drawn: Drawn) -> None:
    extent = [edge / drawn.lengths.unit for edge in drawn.window]
    ax.set_aspect("equal")
    ax.tick_params(color="0.5")
    if name == "contact":
        _show(ax, np.ma.masked_equal(found.contact, 0), extent, CONTACT_MAP, Normalize(0, 1))
        return
    values, largest = found.means[name], found.largest[name]
    scale = drawn.units.of(name, [largest, float(values.min())])
    values, largest = values / scale.unit, largest / scale.unit
    clipped = False
    if name == "pressure":
        ax.set_facecolor(GROUND)
        values = np.ma.masked_where(found.contact == 0, values)
        top = np.percentile(values.compressed(), 99.5) if values.count() else 1.0
        clipped = largest > SPIKY * top > 0
        norm = Normalize(0, top if clipped else largest if largest > 0 else 1.0)
    elif name == "gap":  # square root: most of what matters happens at small gaps
        values = np.ma.masked_where(found.contact >= 0.5, values)
        norm = PowerNorm(0.5, vmin=0, vmax=max(largest, 1e-300))
    else:
        norm = Normalize(values.min(), values.max())
    image = _show(ax, values, extent, COLOURS.get(name, OTHER_MAP), norm)
    bar = fig.colorbar(
        image,
        cax=ax.inset_axes([1.04, 0, 0.06, 1 if not clipped else 0.95]),
        extend="max" if clipped else "neither",
    )
    bar.set_label(scale.label(SYMBOLS[name]))
    if clipped:
        bar.ax.set_title(f"max {largest:.3g}", fontsize=6.5, pad=2, loc="left")


def _show(ax: Any, values: np.ndarray, extent: Any, colours: Any, norm: Any) -> Any:
    return ax.imshow(
        values.T, origin="lower", extent=extent, interpolation="nearest", cmap=colours, norm=norm
    )
