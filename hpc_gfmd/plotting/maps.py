"""Contact, pressure and gap over the cell, one row of panels per load step."""

import numpy as np
from matplotlib.colors import PowerNorm

from ..output.table import converged
from .style import CONTACT_MAP, GAP_MAP, PRESSURE_MAP, WARNING, figure
from .units import gap_unit, over, pressure_unit


def contact_maps(path, result, chosen, surveys):
    """chosen: indices into result.steps; surveys: one Survey for each."""
    width, height = result.surface.get("physical_sizes", (1.0, 1.0))
    columns = [name for name in ("contact", "pressure", "gap") if getattr(surveys[0], name) is not None]
    panel = 2.1 * min(2.0, max(0.5, height / width))
    with figure(path, 2.9 * len(columns), (panel + 0.5) * len(surveys)) as fig:
        axes = fig.subplots(len(surveys), len(columns), squeeze=False)
        for row, k, found in zip(axes, chosen, surveys, strict=True):
            step = result.steps[k]
            for ax, name in zip(row, columns, strict=True):
                image = _DRAW[name](ax, found, (0, width, 0, height))
                _, unit = pressure_unit(step) if name == "pressure" else gap_unit(result.surface)
                if name != "contact":
                    fig.colorbar(image, ax=ax, shrink=0.85).set_label(over(name[0], unit))
                ax.set_xlabel("$x$")
                ax.set_aspect("equal")
            row[0].set_ylabel("$y$")
            row[0].set_title(_title(step), loc="left", color="black" if converged(step) else WARNING)
    return fig


def _title(step) -> str:
    shown = (("p_star", "p^*"), ("a_r", "a_r"))
    parts = [f"${symbol} = {step[key]:.4g}$" for key, symbol in shown if key in step]
    if not converged(step):
        parts.append(f"NOT CONVERGED ({step.get('status', 'unknown')})")
    return ", ".join(parts)


def _draw_contact(ax, found, extent):
    return _show(ax, found.contact, extent, cmap=CONTACT_MAP, vmin=0, vmax=1)


def _draw_pressure(ax, found, extent):
    touching = np.ma.masked_where(found.contact == 0, found.pressure)
    top = np.percentile(touching.compressed(), 99.5) if touching.count() else 1.0
    return _show(ax, touching, extent, cmap=PRESSURE_MAP, vmin=0, vmax=top or 1.0)


def _draw_gap(ax, found, extent):
    """Square root scale: most of what matters happens at small gaps. Contact is white."""
    gap = np.ma.masked_where(found.contact >= 0.5, found.gap)
    norm = PowerNorm(0.5, vmin=0, vmax=max(found.gap.max(), 1e-300))
    return _show(ax, gap, extent, cmap=GAP_MAP, norm=norm)


def _show(ax, values, extent, **how):
    return ax.imshow(values.T, origin="lower", extent=extent, interpolation="nearest", **how)


_DRAW = {"contact": _draw_contact, "pressure": _draw_pressure, "gap": _draw_gap}
