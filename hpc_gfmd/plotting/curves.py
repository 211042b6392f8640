"""Contact area and mean gap over the load, with Persson's theory."""

import numpy as np

from ..output.table import converged
from ..theory import persson
from .style import COLOURS, THEORY, WARNING, figure
from .units import gap_unit, good, self_affine


def curves(path, result):
    """a_r, kappa and mean gap of all steps."""
    steps = [step for step in result.steps if good(step.get("p_star")) or good(step.get("p"))]
    against = "p_star" if steps and all(good(step.get("p_star")) for step in steps) else "p"
    with figure(path, 10.2, 3.2) as fig:
        area, kappa, gap = fig.subplots(1, 3)
        _points(area, steps, against, "a_r", "a_r_error", COLOURS[0], "o", "simulation")
        _points(kappa, steps, against, "kappa", "a_r_error", COLOURS[0], "o", "simulation")
        _points(kappa, steps, against, "kappa_corrected", None, COLOURS[1], "s", "edge-corrected")
        scaled = good(result.surface.get("h_rms"))
        _points(gap, steps, against, "gap_over_h_rms" if scaled else "gap_mean", "gap_error", COLOURS[0], "o",
                "simulation")
        if against == "p_star":
            _theory(area, kappa, gap, result, [step["p_star"] for step in steps])
        _, unit = gap_unit(result.surface)
        labels = ("$a_r$", r"$\kappa = a_r/p^*$", f"mean gap $/{unit}$" if unit else "mean gap")
        for ax, label, log in ((area, labels[0], True), (kappa, labels[1], False), (gap, labels[2], True)):
            _axes(ax, r"$p^* = p_0/(E^* \bar{g})$" if against == "p_star" else "$p_0$", label, log)
    return fig


def _points(ax, steps, against, key, error_key, colour, marker, label) -> None:
    for good_ones in (True, False):
        chosen = [s for s in steps if isinstance(s.get(key), int | float) and converged(s) == good_ones]
        if not chosen:
            continue
        x, y = (np.array([step[name] for step in chosen], dtype=float) for name in (against, key))
        relative = np.array([step.get(error_key) or 0.0 for step in chosen], dtype=float)
        how = {"color": colour, "marker": marker, "label": label}
        if not good_ones:
            how = {"color": WARNING, "marker": "x", "label": "not converged"}
        ax.errorbar(x, y, np.abs(y) * np.where(np.isfinite(relative), relative, 0), linestyle="", capsize=2, **how)


def _theory(area, kappa, gap, result, pressures) -> None:
    p_star = np.geomspace(min(pressures) / 3, max(pressures) * 3, 60)
    area.plot(p_star, persson.contact_area(p_star), label="Persson theory", **THEORY)
    kappa.plot(p_star, persson.kappa(p_star), label="Persson theory", **THEORY)
    shape = self_affine(result)
    if shape is not None and gap_unit(result.surface)[1]:
        # very high loads have gaps below what a picture needs
        gap_theory = np.ma.masked_less(persson.mean_gap(p_star, *shape), 1e-12)
        gap.plot(p_star, gap_theory, label=f"Persson theory, $\\gamma = {persson.GAMMA:g}$", **THEORY)


def _axes(ax, x_label, y_label, log) -> None:
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    lines = ax.get_lines()
    if lines:
        ax.set_xscale("log")
        heights = np.concatenate([np.ma.filled(line.get_ydata(), np.nan).astype(float) for line in lines])
        if log and (heights > 0).any():
            ax.set_yscale("log")
        handles = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
        ax.legend(handles.values(), handles.keys())
