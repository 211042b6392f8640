"""The pictures: data with error bars beside theory, as in the paper; as counted filled,
edge-corrected open.

Colours tell H, marks tell what else differs. Every public function writes one PNG of rows.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hpc_gfmd.plotting.style import COLOURS, THEORY, figure, legend
from hpc_gfmd.theory import elastic, persson

from .levels import HURST, PRESSURES
from .rows import Rows, by_hurst, low_high

MARKS = "osD^v<>P"
LABELS = {
    "eps_c": r"$\epsilon_c = a/\lambda_s$",
    "eps_f": r"$\epsilon_f = \lambda_s/\lambda_l$",
    "eps_t": r"$\epsilon_t = \lambda_l/\mathcal{L}$",
    "kappa": r"$\kappa = a_r/p^*$",
    "gap_over_h_rms": r"$\Delta\bar u/\bar h$",
    "gap_over_g_rms_lam_s": r"$\Delta\bar u/(\bar g \lambda_s)$",
    "p_star": r"$p^* = p/(E^*\bar g)$",
    "a_r": r"$a_r$",
    "p_inverse": r"$1/p^*$",
    "open_area": r"$1 - a_r$",
}
SYMBOLS = {
    "lam_l_over_lam_s": r"\epsilon_f",
    "L_over_lam_l": r"\epsilon_t",
    "lam_s_over_a": r"\epsilon_c",
}
TITLES = {"low": r"$p^* = 0.01/\sqrt{2}$", "high": r"$p^* = 0.5/\sqrt{2}$"}
KAPPA_TFC = r"$\kappa$ in the TFC limit, " + TITLES["low"]
LARGEST_EPS_F = 0.5  # up to which theory is drawn
CLOSED = 1e-5  # gap/h_rms below which theory is not drawn


def two_pressures(
    rows: Rows,
    path: Path,
    x: str,
    observable: str,
    series: str = "lam_l_over_lam_s",
    theory: Callable | None = None,
    base: int = 2,
) -> None:
    """Two panels, the low and the high pressure of the paper: an observable, and NAME_edge where
    there is one, against a ratio.

    series: the column whose values get marks of their own, named in the legend where there are
    several; theory: function (ax, name of the pressure, H of the rows, range of x) that draws
    lines; base: of the logarithmic abscissa.
    """
    marks = list(zip(sorted({row[series] for row in rows}), MARKS, strict=False))
    with figure(path, 8.4, 3.3) as fig:
        axes = fig.subplots(1, 2)
        for ax, (pressure, part) in zip(axes, low_high(rows).items(), strict=True):
            for hurst, family in by_hurst(part).items():
                for member, mark in marks:
                    _both_areas(
                        ax,
                        [row for row in family if row[series] == member],
                        x,
                        observable,
                        _colour(hurst),
                        mark,
                    )
            ax.set_xscale("log", base=base)
            if theory and part:
                values = [row[x] for row in part]
                theory(ax, pressure, list(by_hurst(part)), (min(values), max(values)))
            ax.set(xlabel=LABELS[x], ylabel=LABELS[observable], title=TITLES[pressure])
        _legend(
            fig,
            rows,
            any(f"{observable}_edge" in row for row in rows),
            marks if len(marks) > 1 else (),
            series,
        )


def kappa_lines(ax: Any, pressure: str, _hursts: object, _range: object) -> None:
    """Persson's kappa and, at low load, that of Bush, Gibson and Thomas."""
    ax.axhline(float(persson.kappa(PRESSURES[pressure])), label="Persson", **THEORY)
    if pressure == "low":
        ax.axhline(elastic.KAPPA_BGT, linestyle=":", label="BGT", **THEORY)


def gap_lines(unit: str, widest: tuple[float, float] | None = None) -> Callable:
    """A function for two_pressures: the mean gap of Persson's theory in a unit over the range of
    eps_f of the data or over `widest`, with logarithmic ordinates."""

    def draw(
        ax: Any, pressure: str, hursts: Sequence[float], eps_range: tuple[float, float]
    ) -> None:
        low, high = widest or (eps_range[0] / 2, eps_range[1] * 2)
        eps_f = np.geomspace(low, min(high, LARGEST_EPS_F), 25)
        for hurst in hursts:
            _both_theories(
                ax,
                _colour(hurst),
                lambda printed, hurst=hurst: (
                    eps_f,
                    [
                        float(
                            persson.mean_gap(
                                PRESSURES[pressure], hurst, e, printed=printed, unit=unit
                            )
                        )
                        for e in eps_f
                    ],
                ),
            )
        _theory_keys(ax)
        ax.set_yscale("log")

    return draw


def pressure_against_gap(rows: Rows, path: Path) -> None:
    """p* against gap/h_rms for several eps_f at one H, with Persson's theory."""
    with figure(path, 5.0, 3.8) as fig:
        ax = fig.subplots()
        p_star = np.geomspace(min((row["p_star"] for row in rows), default=1e-3) / 2, 2.5, 60)
        for eps_f, shade, mark in zip(
            sorted({row["eps_f"] for row in rows}, reverse=True), COLOURS, MARKS, strict=False
        ):
            chosen = [row for row in rows if row["eps_f"] == eps_f]
            points(
                ax,
                chosen,
                "gap_over_h_rms",
                "p_star",
                shade,
                mark,
                label=f"$\\epsilon_f = 1/{1 / eps_f:g}$",
            )
            _both_theories(
                ax,
                shade,
                lambda printed, hurst=chosen[0]["hurst"], eps_f=eps_f: (
                    np.ma.masked_less(
                        persson.mean_gap(p_star, hurst, eps_f, printed=printed), CLOSED
                    ),
                    p_star,
                ),
            )
        _theory_keys(ax)
        title = f"$H = {rows[0]['hurst']:g}$" if rows else ""
        ax.set(yscale="log", xlabel=LABELS["gap_over_h_rms"], ylabel=LABELS["p_star"], title=title)
        ax.legend()


def areas(rows: Rows, path: Path, panels: Sequence[tuple], width: float) -> None:
    """One panel for each (x, y, function of p_star that gives the theory's y, keywords of ax.set):
    as counted and edge-corrected."""
    with figure(path, width, 3.3) as fig:
        axes = fig.subplots(1, len(panels), squeeze=False)[0]
        loads = [row["p_star"] for row in rows] or [1e-3, 1]
        p_star = np.geomspace(min(loads) / 1.5, max(loads) * 1.2, 80)
        for ax, (x, y, theory, settings) in zip(axes, panels, strict=True):
            for hurst, part in by_hurst(rows).items():
                _both_areas(ax, part, x, y, _colour(hurst), "o")
            ax.plot(
                1 / p_star if x == "p_inverse" else p_star,
                theory(p_star),
                label="Persson",
                **THEORY,
            )
            ax.set(xlabel=LABELS[x], ylabel=LABELS[y], **settings)
        _legend(fig, rows, True)


def coefficients(rows: Rows, path: Path) -> None:
    """The three terms of eq. tfc at the reference system, ours beside the paper's, against H."""
    with figure(path, 9.0, 2.8) as fig:
        for ax, term in zip(fig.subplots(1, 3), "cft", strict=True):
            for k, (area, label) in enumerate(
                (("raw", "ours"), ("edge", "ours, edge-corrected"), ("paper", "paper"))
            ):
                chosen = [
                    row | {"at": row["hurst"] + 0.012 * (k - 1)}
                    for row in rows
                    if row["area"] == area and row["exponents"] in ("free", "printed")
                ]
                points(
                    ax, chosen, "at", f"term_{term}", COLOURS[k], MARKS[k], area == "edge", label
                )
            ax.axhline(0, color="0.8", linewidth=0.8, zorder=0)
            ax.set(
                xlabel="$H$",
                ylabel=f"$C_{term} \\epsilon_{term}^{{\\alpha_{term}}}$ at the reference",
            )
        _legend(fig)


def limits(rows: Rows, path: Path) -> None:
    """kappa in the TFC limit against H, with the paper, other authors at H = 0.8 and theories."""
    kinds = (
        ("raw", -0.008, 0, "o", False, "ours, as counted"),
        ("edge", 0.008, 0, "o", True, "ours, edge-corrected"),
        ("paper", 0.0, 1, "s", False, "paper"),
    )
    with figure(path, 6.2, 3.4) as fig:
        ax = fig.subplots()
        for area, shift, shade, mark, open_mark, label in kinds:
            chosen = [
                row | {"at": row["hurst_number"] + shift} for row in rows if row["area"] == area
            ]
            points(ax, chosen, "at", "kappa_tfc", COLOURS[shade], mark, open_mark, label)
        for row, mark in zip(
            (row for row in rows if row["area"] == "literature"), MARKS[2:], strict=False
        ):
            label = f"{row['authors'].split(',')[0]} {row['year']}"
            points(ax, [row | {"at": 0.8}], "at", "kappa_08", COLOURS[2], mark, label=label)
        ax.axhline(persson.KAPPA_LOW_LOAD, label="Persson", **THEORY)
        ax.axhline(elastic.KAPPA_BGT, linestyle=":", label="BGT", **THEORY)
        ax.set(xlabel="$H$", ylabel=KAPPA_TFC)
        _legend(fig)


def points(
    ax: Any,
    rows: Rows,
    x: str,
    y: str,
    shade: str,
    mark: str = "o",
    open_mark: bool = False,
    label: str | None = None,
    line: str = "",
    size: float = 4,
) -> None:
    """Data with the error bars that they have (columns NAME_se), joined by a line where one is
    wanted; rows without y are left out."""
    rows = [row for row in rows if row.get(y) is not None]
    if rows:
        errors = [[row.get(f"{name}_se") or 0.0 for row in rows] for name in (y, x)]
        bars = (values if any(values) else None for values in errors)
        ax.errorbar(
            [row[x] for row in rows],
            [row[y] for row in rows],
            *bars,
            color=shade,
            marker=mark,
            linestyle=line,
            linewidth=0.8,
            markerfacecolor="white" if open_mark else shade,
            capsize=2,
            markersize=size,
            label=label,
            zorder=3,
        )


def _colour(hurst: float) -> str:
    """The colour of a Hurst exponent, the same in all pictures."""
    return COLOURS[min(range(len(HURST)), key=lambda i: abs(HURST[i] - hurst))]


def _both_areas(ax: Any, rows: Rows, x: str, y: str, shade: str, mark: str) -> None:
    """Filled marks for y as counted, open ones for y edge-corrected."""
    points(ax, rows, x, y, shade, mark)
    points(ax, rows, x, f"{y}_edge", shade, mark, open_mark=True)


def _both_theories(ax: Any, shade: str, curve: Callable) -> None:
    """curve(printed), corrected (solid) and as printed (dashed)."""
    for printed, style in ((False, "-"), (True, "--")):
        ax.plot(*curve(printed), color=shade, linestyle=style, linewidth=1)


def _theory_keys(ax: Any) -> None:
    ax.plot([], [], label="Persson, corrected", **THEORY)
    ax.plot([], [], linestyle="--", label="Persson, as printed", **THEORY)


def _legend(
    fig: Any,
    rows: Rows | None = None,
    edge: bool = False,
    marks: Sequence[tuple] = (),
    series: str = "",
) -> None:
    """One legend for all panels, beside them: colours of the rows' H, filled and open marks, marks
    of a series, labelled lines."""

    def key(shade: str, mark: str, label: str | None, face: str | None = None) -> None:
        fig.axes[0].plot(
            [],
            [],
            color=shade,
            marker=mark,
            linestyle="",
            markersize=4,
            markerfacecolor=face or shade,
            label=label,
        )

    for hurst in by_hurst(rows or []):
        key(_colour(hurst), "o", f"$H = {hurst:g}$")
    if edge:
        key("0.35", "o", "as counted")
        key("0.35", "o", "edge-corrected", "white")
    for member, mark in marks:
        key("0.35", mark, f"${SYMBOLS[series]} = 1/{member:g}$")
    legend(fig, "outside right upper")
