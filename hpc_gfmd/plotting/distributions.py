"""Distributions of pressure and gap, with Persson's pressure distribution."""

import numpy as np

from ..output.table import converged
from ..theory import persson
from .style import COLOURS, THEORY, figure
from .units import gap_unit, good, over, pressure_unit


def distributions(path, result, chosen, surveys):
    """chosen: indices into result.steps; surveys: one Survey for each."""
    has_gap = surveys[0].gap_density is not None
    has_pressure = surveys[0].pressure_density is not None
    with figure(path, 3.6 * (has_gap + has_pressure), 3.2) as fig:
        axes = list(fig.subplots(1, has_gap + has_pressure, squeeze=False)[0])
        if has_pressure:
            _pressures(axes.pop(0), result, chosen, [found.pressure_density for found in surveys])
        if has_gap:
            _gaps(axes.pop(0), result, chosen, [found.gap_density for found in surveys])
    return fig


def _pressures(ax, result, chosen, densities) -> None:
    theory = None
    for colour, k, (x, density) in zip(COLOURS, chosen, densities, strict=False):
        step = result.steps[k]
        if len(x):
            ax.plot(x, density, "o", color=colour, markersize=3, label=_label(step))
            if good(step.get("p_star")):
                fine = np.geomspace(x[0], x[-1], 200)
                (theory,) = ax.plot(fine, persson.pressure_distribution(fine, step["p_star"]), **THEORY)
    if theory is not None:
        theory.set_label("Persson theory")
    _, unit = pressure_unit(result.steps[chosen[0]])
    _finish(ax, "p", unit, densities)


def _gaps(ax, result, chosen, densities) -> None:
    for colour, k, (x, density) in zip(COLOURS, chosen, densities, strict=False):
        if len(x):
            label = _label(result.steps[k])
            ax.plot(x, density, "o-", color=colour, markersize=3, linewidth=0.8, label=label)
    _, unit = gap_unit(result.surface)
    _finish(ax, "g", unit, densities)


def _finish(ax, symbol, unit, densities) -> None:
    x, found = np.concatenate(densities, axis=1)
    if len(found):
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlim(max(x.min(), x.max() * 1e-5) / 1.5, x.max() * 1.5)
        ax.set_ylim(max(found.min(), found.max() * 1e-7) / 2, found.max() * 3)
        ax.legend()
    else:
        ax.text(0.5, 0.5, "none", ha="center", transform=ax.transAxes)
    ax.set_xlabel(over(symbol, unit))
    ax.set_ylabel(f"$P({symbol}) \\cdot {unit}$" if unit else f"$P({symbol})$")


def _label(step) -> str:
    symbol, key = ("p^*", "p_star") if good(step.get("p_star")) else ("p", "p")
    name = f"${symbol} = {step.get(key, np.nan):.3g}$"
    return name if converged(step) else f"{name}, not converged"
