"""Pictures of data with error bars beside theory.

Filled marks are areas as counted, open marks edge-corrected ones. The colour shows H, the mark any
other ratio. A panel is a matplotlib Axes; all panels of a picture share one legend.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from PIL import Image

from hpc_gfmd.plotting.style import THEORY, Picture, legend, save, styled
from hpc_gfmd.theory import elastic, persson

from .rows import PRESSURES, Rows, by_hurst, groups, low_high

MARKS = "osD^v<>P"
PALETTE = 48  # colours of a PNG file: more make no visible difference
LABELS = {
    "eps_c": r"$\epsilon_c = a/\lambda_s$",
    "eps_f": r"$\epsilon_f = \lambda_s/\lambda_l$",
    "eps_t": r"$\epsilon_t = \lambda_l/L$",
    "kappa": r"$\kappa = a_r/p^*$",
    "kappa_tfc": r"$\kappa$ in the TFC limit",
    "gap_over_h_rms": r"$\langle g\rangle/h_\mathrm{rms}$",
    "gap_over_g_rms_lam_s": r"$\langle g\rangle/(g_\mathrm{rms} \lambda_s)$",
    "p_star": r"$p^* = p/(E^* g_\mathrm{rms})$",
    "a_r": r"$a_r$",
    "p_inverse": r"$1/p^*$",
    "open_area": r"$1 - a_r$",
    "L_over_lam_l": r"$L/\lambda_l$",
    "hurst": "$H$",
}
TITLES = {"low": r"$p^* = 0.01/\sqrt{2}$", "high": r"$p^* = 0.5/\sqrt{2}$"}
LARGEST_EPS_F = 0.5  # up to which theory is drawn
SHADES = matplotlib.colormaps["viridis"]  # of an ordered series, from 0 to 1
SMALLEST_GAP = 1e-5  # gap/h_rms from which theory is drawn


@contextmanager
def panels(path: Path, columns: int, lines: int = 1, **settings: Any) -> Iterator[Any]:
    """Yield the panels of a picture, which is written at the end: an Axes, or an array (columns,)
    or (lines, columns). **settings are arguments of Figure.subplots."""
    with styled():
        size = (2.0 + 2.4 * columns, 0.6 + 2.4 * lines)
        fig = Picture(figsize=size, layout="constrained")
        axes = fig.subplots(lines, columns, squeeze=False, **settings)
        yield axes if lines > 1 else axes[0] if columns > 1 else axes[0, 0]
        legend(fig, "outside right upper")
        save(fig, path)
    Image.open(path).quantize(PALETTE).save(path, optimize=True)


def colour(hurst: float) -> Any:
    """Return the colour of a Hurst exponent, the same in all pictures."""
    return SHADES(0.9 * hurst)


def hurst_style(hurst: float) -> dict[str, Any]:
    """Return the colour and the label of a Hurst exponent, for Axes.plot."""
    return {"color": colour(hurst), "label": f"$H = {hurst:g}$"}


def label_axes(ax: Any, x: str, y: str, **settings: Any) -> None:
    """Label the axes of a panel with columns or texts; **settings are arguments of Axes.set."""
    ax.set(**{"xlabel": LABELS.get(x, x), "ylabel": LABELS.get(y, y)} | settings)


def draw_points(
    ax: Any, rows: Rows, x: str, y: str, mark: str = "o", is_open: bool = False, **style: Any
) -> None:
    """Draw one column against another, with error bars where there are standard errors; rows
    without y are skipped. **style are arguments of Axes.errorbar."""
    rows = [row for row in rows if row.get(y) is not None]
    if rows:
        defaults = {"linestyle": "", "linewidth": 0.8, "markersize": 4, "capsize": 2, "zorder": 3}
        ax.errorbar(
            [row[x] for row in rows],
            [row[y] for row in rows],
            yerr=_error_bars(rows, y),
            xerr=_error_bars(rows, x),
            marker=mark,
            markerfacecolor="white" if is_open else style.get("color"),
            **defaults | style,
        )


def _error_bars(rows, column):
    bars = [row.get(f"{column}_se") or 0.0 for row in rows]
    return bars if any(bars) else None


def draw_both_areas(ax: Any, rows: Rows, x: str, y: str, mark: str = "o") -> None:
    """Draw y for each H: as counted with filled marks, edge-corrected (column y_edge) with open
    ones."""
    for hurst, family in by_hurst(rows).items():
        draw_points(ax, family, x, y, mark, **hurst_style(hurst))
        draw_points(ax, family, x, f"{y}_edge", mark, is_open=True, color=colour(hurst))


def draw_both_theories(ax: Any, color: Any, curve: Callable[[bool], tuple]) -> None:
    """Draw Persson's theory, corrected (solid) and as printed (dashed); curve(printed) returns x
    and y."""
    for printed, style, name in ((False, "-", "corrected"), (True, "--", "as printed")):
        ax.plot(*curve(printed), color=color, linestyle=style, linewidth=1)
        ax.plot([], [], linestyle=style, label=f"Persson, {name}", **THEORY)


def explain_mark(ax: Any, label: str, mark: str, face: str = "0.35") -> None:
    """Add a mark, and the colour of its face, to the legend of a picture."""
    style = {"color": "0.35", "linestyle": "", "markersize": 4}
    ax.plot([], [], marker=mark, markerfacecolor=face, label=label, **style)


def two_pressures(
    rows: Rows,
    path: Path,
    x: str,
    y: str,
    theory: Callable | None = None,
    base: int = 2,
    logarithmic: bool = False,
) -> None:
    """Draw a column against eps_c, eps_f or eps_t at the low and the high pressure of the paper.

    The marks show lam_l/lam_s where it is not the abscissa. theory(ax, p_star, list of H, range of
    x) draws lines; `base` is that of the logarithmic abscissa.
    """
    series = "lam_s_over_a" if x == "eps_f" else "lam_l_over_lam_s"
    marks = dict(zip(sorted({row[series] for row in rows}), MARKS))
    with panels(path, 2) as axes:
        for ax, (pressure, part) in zip(axes, low_high(rows).items()):
            for ratio, family in groups(part, series).items():
                draw_both_areas(ax, family, x, y, marks[ratio])
            ax.set_xscale("log", base=base)
            if theory and part:
                span = min(row[x] for row in part), max(row[x] for row in part)
                theory(ax, PRESSURES[pressure], list(by_hurst(part)), span)
            label_axes(ax, x, y, title=TITLES[pressure], yscale="log" if logarithmic else "linear")
        if any(f"{y}_edge" in row for row in rows):
            explain_mark(axes[0], "as counted", "o")
            explain_mark(axes[0], "edge-corrected", "o", "white")
        for ratio, mark in marks.items():
            if len(marks) > 1:
                explain_mark(axes[0], f"$\\lambda_l/\\lambda_s = {ratio:g}$", mark)


def draw_kappa_theory(ax: Any, p_star: float, *_unused: object) -> None:
    """Draw Persson's kappa and, at low loads, that of Bush, Gibson and Thomas."""
    ax.axhline(float(persson.kappa(p_star)), label="Persson", **THEORY)
    if p_star < 0.1:
        ax.axhline(elastic.KAPPA_BGT, linestyle=":", label="BGT", **THEORY)


def gap_theory(unit: str, eps_f_range: Sequence[float] = ()) -> Callable:
    """Return a function for `two_pressures` that draws the mean gap of Persson's theory in a unit,
    h_rms or g_rms_lam_s, over a range of eps_f or about that of the data."""

    def draw(ax, p_star, hursts, span):
        low, high = eps_f_range or (span[0] / 2, span[1] * 2)
        eps_f = np.geomspace(low, min(high, LARGEST_EPS_F), 25)
        for H in hursts:

            def curve(printed, H=H):
                gap = (persson.mean_gap(p_star, H, e, printed=printed, unit=unit) for e in eps_f)
                return eps_f, [float(x) for x in gap]

            draw_both_theories(ax, colour(H), curve)

    return draw


def pressure_against_gap(rows: Rows, path: Path) -> None:
    """Draw p* against gap/h_rms for several eps_f at one H, with Persson's theory."""
    with panels(path, 1) as ax:
        p_star = np.geomspace(min((row["p_star"] for row in rows), default=1e-3) / 2, 2.5, 60)
        for (eps_f, hurst), part in groups(rows, "eps_f", "hurst").items():
            color = SHADES(-np.log10(eps_f) / 4)
            label = f"$\\epsilon_f = 1/{1 / eps_f:g}$"
            draw_points(ax, part, "gap_over_h_rms", "p_star", color=color, label=label)

            def curve(printed, H=hurst, e=eps_f):
                gap = persson.mean_gap(p_star, H, e, printed=printed)
                return np.ma.masked_less(gap, SMALLEST_GAP), p_star

            draw_both_theories(ax, color, curve)
            ax.set(title=f"$H = {hurst:g}$")
        label_axes(ax, "gap_over_h_rms", "p_star", yscale="log")


def areas(rows: Rows, path: Path, specs: Sequence[tuple]) -> None:
    """Draw contact areas with Persson's theory; specs has (x, y, theory, settings) of each panel:
    columns, function of p_star that returns y, and arguments of Axes.set."""
    loads = [row["p_star"] for row in rows] or [1e-3, 1]
    p_star = np.geomspace(min(loads) / 1.5, max(loads) * 1.2, 80)
    with panels(path, len(specs)) as axes:
        for ax, (x, y, theory, settings) in zip(np.atleast_1d(axes), specs):
            draw_both_areas(ax, rows, x, y)
            abscissa = 1 / p_star if x == "p_inverse" else p_star
            ax.plot(abscissa, theory(p_star), label="Persson", **THEORY)
            explain_mark(ax, "edge-corrected", "o", "white")
            label_axes(ax, x, y, **settings)
