"""The pictures: data with error bars beside theory; as counted filled, edge-corrected open.

Colours tell H, marks tell what else differs. A panel is a matplotlib Axes; all panels of a picture
share one legend.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from hpc_gfmd.plotting.style import THEORY, figure, legend, shade
from hpc_gfmd.theory import elastic, persson

from .rows import PRESSURES, Rows, by_hurst, groups, low_high

MARKS = "osD^v<>P"
PALETTE = 48  # colours of a picture, as many as show no difference
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
WIDEST = 0.5  # eps_f up to which theory is drawn
CLOSED = 1e-5  # gap/h_rms below which theory is not drawn


@contextmanager
def panels(path: Path, columns: int, lines: int = 1, **how: Any) -> Iterator[Any]:
    """Yield the Axes of a picture, which is written at the end.

    how: of Figure.subplots. One panel is an Axes, others an array (columns,) or (lines, columns).
    """
    with figure(path, 2.0 + 2.4 * columns, 0.6 + 2.4 * lines) as fig:
        axes = fig.subplots(lines, columns, squeeze=False, **how)
        yield axes if lines > 1 else axes[0] if columns > 1 else axes[0, 0]
        legend(fig, "outside right upper")
    Image.open(path).quantize(PALETTE).save(path, optimize=True)


def colour(hurst: float) -> Any:
    """Choose the colour of a Hurst exponent, the same in all pictures."""
    return shade(0.9 * hurst)


def of_h(hurst: float) -> dict[str, Any]:
    """Choose colour and label of a Hurst exponent."""
    return {"color": colour(hurst), "label": f"$H = {hurst:g}$"}


def named(ax: Any, x: str, y: str, **settings: Any) -> None:
    """Name the axes of a panel after columns; settings: of Axes.set."""
    ax.set(**{"xlabel": LABELS.get(x, x), "ylabel": LABELS.get(y, y)} | settings)


def points(
    ax: Any, rows: Rows, x: str, y: str, mark: str = "o", hollow: bool = False, **how: Any
) -> None:
    """Draw columns with the error bars that they have; rows without y are left out.

    how: of Axes.errorbar, such as color, label, linestyle.
    """
    rows = [row for row in rows if row.get(y) is not None]
    if rows:
        bars = ([row.get(f"{name}_se") or 0.0 for row in rows] for name in (y, x))
        usual = {"linestyle": "", "linewidth": 0.8, "markersize": 4, "capsize": 2, "zorder": 3}
        ax.errorbar(
            *([row[name] for row in rows] for name in (x, y)),
            *(bar if any(bar) else None for bar in bars),
            marker=mark,
            markerfacecolor="white" if hollow else how.get("color"),
            **usual | how,
        )


def both_areas(ax: Any, rows: Rows, x: str, y: str, mark: str = "o") -> None:
    """Draw y as counted, filled, and edge-corrected, open, for each H."""
    for hurst, part in by_hurst(rows).items():
        points(ax, part, x, y, mark, **of_h(hurst))
        points(ax, part, x, f"{y}_edge", mark, hollow=True, color=colour(hurst))


def both_theories(ax: Any, color: Any, curve: Callable[[bool], tuple]) -> None:
    """Draw curve(printed), corrected (solid) and as printed (dashed)."""
    for printed, style, name in ((False, "-", "corrected"), (True, "--", "as printed")):
        ax.plot(*curve(printed), color=color, linestyle=style, linewidth=1)
        ax.plot([], [], linestyle=style, label=f"Persson, {name}", **THEORY)


def key(ax: Any, label: str, mark: str, face: str = "0.35") -> None:
    """Explain a mark in the legend."""
    how = {"color": "0.35", "linestyle": "", "markersize": 4}
    ax.plot([], [], marker=mark, markerfacecolor=face, label=label, **how)


def two_pressures(
    rows: Rows,
    path: Path,
    x: str,
    y: str,
    theory: Callable | None = None,
    base: int = 2,
    logarithmic: bool = False,
) -> None:
    """Draw y against a ratio at the low and the high pressure of the paper.

    Marks tell lam_l/lam_s where it is not the abscissa. theory: function (ax, p_star, H of the
    rows, range of x) that draws lines; base: of the abscissa.
    """
    series = "lam_s_over_a" if x == "eps_f" else "lam_l_over_lam_s"
    marks = dict(zip(sorted({row[series] for row in rows}), MARKS))
    with panels(path, 2) as axes:
        for ax, (pressure, part) in zip(axes, low_high(rows).items()):
            for member, family in groups(part, series).items():
                both_areas(ax, family, x, y, marks[member])
            ax.set_xscale("log", base=base)
            if theory and part:
                span = [of(row[x] for row in part) for of in (min, max)]
                theory(ax, PRESSURES[pressure], list(by_hurst(part)), span)
            named(ax, x, y, title=TITLES[pressure], yscale="log" if logarithmic else "linear")
        if any(f"{y}_edge" in row for row in rows):
            key(axes[0], "as counted", "o")
            key(axes[0], "edge-corrected", "o", "white")
        for member, mark in marks.items():
            if len(marks) > 1:
                key(axes[0], f"$\\lambda_l/\\lambda_s = {member:g}$", mark)


def kappa_lines(ax: Any, p_star: float, *_unused: object) -> None:
    """Draw Persson's kappa and, at low load, that of Bush, Gibson and Thomas."""
    ax.axhline(float(persson.kappa(p_star)), label="Persson", **THEORY)
    if p_star < 0.1:
        ax.axhline(elastic.KAPPA_BGT, linestyle=":", label="BGT", **THEORY)


def gap_lines(unit: str, widest: Sequence[float] = ()) -> Callable:
    """Make a function for two_pressures: the mean gap of Persson's theory in a unit, over the range
    of eps_f of the data or over `widest`."""

    def draw(ax, p_star, hursts, span):
        low, high = widest or (span[0] / 2, span[1] * 2)
        eps_f = np.geomspace(low, min(high, WIDEST), 25)
        for H in hursts:

            def curve(printed, H=H):
                gap = (persson.mean_gap(p_star, H, e, printed=printed, unit=unit) for e in eps_f)
                return eps_f, [float(x) for x in gap]

            both_theories(ax, colour(H), curve)

    return draw


def pressure_against_gap(rows: Rows, path: Path) -> None:
    """Draw p* against gap/h_rms for several eps_f at one H, with Persson's theory."""
    with panels(path, 1) as ax:
        p_star = np.geomspace(min((row["p_star"] for row in rows), default=1e-3) / 2, 2.5, 60)
        for (eps_f, hurst), part in groups(rows, "eps_f", "hurst").items():
            color = shade(-np.log10(eps_f) / 4)
            label = f"$\\epsilon_f = 1/{1 / eps_f:g}$"
            points(ax, part, "gap_over_h_rms", "p_star", color=color, label=label)

            def curve(printed, H=hurst, e=eps_f):
                gap = persson.mean_gap(p_star, H, e, printed=printed)
                return np.ma.masked_less(gap, CLOSED), p_star

            both_theories(ax, color, curve)
            ax.set(title=f"$H = {hurst:g}$")
        named(ax, "gap_over_h_rms", "p_star", yscale="log")


def areas(rows: Rows, path: Path, specs: Sequence[tuple]) -> None:
    """Draw one panel for each (x, y, function of p_star that gives the theory's y, settings)."""
    loads = [row["p_star"] for row in rows] or [1e-3, 1]
    p_star = np.geomspace(min(loads) / 1.5, max(loads) * 1.2, 80)
    with panels(path, len(specs)) as axes:
        for ax, (x, y, theory, settings) in zip(np.atleast_1d(axes), specs):
            both_areas(ax, rows, x, y)
            at = 1 / p_star if x == "p_inverse" else p_star
            ax.plot(at, theory(p_star), label="Persson", **THEORY)
            key(ax, "edge-corrected", "o", "white")
            named(ax, x, y, **settings)
