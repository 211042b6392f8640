"""The pictures: data with error bars beside theory, as in the paper; as counted filled, edge-corrected open.

Colours tell H, marks tell what else differs. Every function writes one PNG under the path it is given.
"""

import numpy as np

from ..plotting.style import COLOURS, THEORY, figure
from ..theory import elastic, persson
from .averages import low_high
from .levels import HURST, P_HIGH, P_LOW

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
}
PRESSURES = {"low": (P_LOW, r"$p^* = 0.01/\sqrt{2}$"), "high": (P_HIGH, r"$p^* = 0.5/\sqrt{2}$")}
WIDEST_INVERSE = 6.0  # 1/p* up to which the open area is drawn
_UNIT = {"gap_over_h_rms": "h_rms", "gap_over_g_rms_lam_s": "g_rms_lam_s"}


def colour(hurst):
    """The colour of a Hurst exponent, the same in all pictures."""
    near = min(range(len(HURST)), key=lambda i: abs(HURST[i] - hurst))
    return COLOURS[near]


def two_pressures(path, rows, x, observable, families="lam_l_over_lam_s", edge=False, theory=None, log_y=False, wide=False):
    """Two panels, the low and the high pressure of the paper: an observable against a ratio.

    families: the column whose values get marks of their own, named in the legend where there are several; edge: draw NAME_edge, too;
    theory: function (ax, name of the pressure, hurst values, x range) that draws lines; log_y: logarithmic ordinates;
    wide: the abscissa spans decades, not octaves.
    """
    members = sorted({row[families] for row in rows})
    with figure(path, 8.4, 3.3) as fig:
        axes = fig.subplots(1, 2)
        for ax, (name, part) in zip(axes, low_high(rows).items(), strict=True):
            for hurst in sorted({row["hurst"] for row in part}):
                for member, mark in zip(members, MARKS, strict=False):
                    chosen = [row for row in part if row["hurst"] == hurst and row[families] == member]
                    points(ax, chosen, x, observable, colour(hurst), mark)
                    if edge:
                        points(ax, chosen, x, f"{observable}_edge", colour(hurst), mark, open_mark=True)
            ax.set_xscale("log", base=2 if not wide else 10)
            if log_y:
                ax.set_yscale("log")
            if theory and part:
                values = [row[x] for row in part]
                theory(ax, name, sorted({row["hurst"] for row in part}), (min(values), max(values)))
            ax.set(xlabel=LABELS[x], ylabel=LABELS[observable], title=PRESSURES[name][1])
        _keys(axes[0], rows, edge, zip(members, MARKS, strict=False) if len(members) > 1 else (), families)
        _legend(fig, axes)


def points(ax, rows, x, observable, shade, mark, open_mark=False, label=None):
    """Data with error bars; rows without the observable are left out."""
    rows = [row for row in rows if row.get(observable) is not None]
    if rows:
        sigma = [row.get(f"{observable}_se") or 0.0 for row in rows]
        ax.errorbar(
            [row[x] for row in rows],
            [row[observable] for row in rows],
            sigma,
            color=shade,
            marker=mark,
            linestyle="",
            markerfacecolor="white" if open_mark else shade,
            capsize=2,
            markersize=4,
            label=label,
            zorder=3,
        )


def kappa_lines(ax, name, _hursts, _range):
    """Persson's kappa and, at low load, that of Bush, Gibson and Thomas."""
    ax.axhline(float(persson.kappa(PRESSURES[name][0])), label="Persson", **THEORY)
    if name == "low":
        ax.axhline(elastic.KAPPA_BGT, linestyle=":", label="BGT", **THEORY)


def gap_lines(observable, widest=None):
    """A function for two_pressures: the mean gap of Persson's theory, corrected (solid) and as printed (dashed), over the range of
    eps_f of the data or over `widest`."""

    def draw(ax, name, hursts, eps_range):
        low, high = widest or (eps_range[0] / 2, eps_range[1] * 2)
        eps_f = np.geomspace(low, min(high, 0.5), 25)
        for hurst in hursts:
            for printed in (False, True):
                gap = [float(persson.mean_gap(PRESSURES[name][0], hurst, e, printed=printed, unit=_UNIT[observable])) for e in eps_f]
                ax.plot(eps_f, gap, color=colour(hurst), linestyle="--" if printed else "-", linewidth=1)
        ax.plot([], [], label="Persson, corrected", **THEORY)
        ax.plot([], [], linestyle="--", label="Persson, as printed", **THEORY)

    return draw


def pressure_against_gap(path, rows):
    """p* against gap/h_rms for several eps_f at one H, with Persson's theory, corrected and as printed."""
    with figure(path, 5.0, 3.8) as fig:
        ax = fig.subplots()
        p_star = np.geomspace(min((row["p_star"] for row in rows), default=1e-3) / 2, 2.5, 60)
        for eps_f, shade, mark in zip(sorted({row["eps_f"] for row in rows}, reverse=True), COLOURS, MARKS, strict=False):
            chosen = [row for row in rows if row["eps_f"] == eps_f]
            points(ax, chosen, "gap_over_h_rms", "p_star", shade, mark, label=f"$\\epsilon_f = 1/{1 / eps_f:g}$")
            sigma = [row["gap_over_h_rms_se"] or 0.0 for row in chosen]
            ax.errorbar(
                [row["gap_over_h_rms"] for row in chosen],
                [row["p_star"] for row in chosen],
                xerr=sigma,
                color=shade,
                linestyle="",
                capsize=2,
            )
            for printed in (False, True):
                gap = np.ma.masked_less(persson.mean_gap(p_star, chosen[0]["hurst"], eps_f, printed=printed), 1e-5)
                ax.plot(gap, p_star, color=shade, linestyle="--" if printed else "-", linewidth=1)
        ax.plot([], [], label="Persson, corrected", **THEORY)
        ax.plot([], [], linestyle="--", label="Persson, as printed", **THEORY)
        ax.set(
            yscale="log", xlabel=LABELS["gap_over_h_rms"], ylabel=LABELS["p_star"], title=f"$H = {rows[0]['hurst']:g}$" if rows else ""
        )
        ax.legend()


def areas(path, rows, high):
    """a_r against p* and a_r/p*, or with `high` 1 - a_r against 1/p*, with Persson's theory."""
    with figure(path, 5.6 if high else 8.4, 3.3) as fig:
        axes = [fig.subplots()] if high else list(fig.subplots(1, 2))
        for hurst in sorted({row["hurst"] for row in rows}):
            chosen = [row for row in rows if row["hurst"] == hurst]
            for ax, x, y in zip(
                axes, ("p_inverse",) if high else ("p_star", "p_star"), ("open_area",) if high else ("a_r", "kappa"), strict=True
            ):
                points(ax, chosen, x, y, colour(hurst), "o")
                points(ax, chosen, x, f"{y}_edge", colour(hurst), "o", open_mark=True)
        p_star = np.geomspace(
            min((row["p_star"] for row in rows), default=1e-3) / 1.5, max((row["p_star"] for row in rows), default=1) * 1.2, 80
        )
        if high:
            axes[0].plot(1 / p_star, persson.noncontact_area(p_star), label="Persson", **THEORY)
            axes[0].set(xlabel=r"$1/p^*$", ylabel=r"$1 - a_r$", yscale="log", xlim=(0, WIDEST_INVERSE), ylim=(1e-4, 1))
        else:
            axes[0].plot(p_star, persson.contact_area(p_star), label="Persson", **THEORY)
            axes[1].plot(p_star, persson.kappa(p_star), label="Persson", **THEORY)
            axes[0].set(xlabel=LABELS["p_star"], ylabel=LABELS["a_r"], xscale="log", yscale="log")
            axes[1].set(xlabel=LABELS["p_star"], ylabel=LABELS["kappa"], xscale="log")
        _keys(axes[0], rows, True, (), None)
        _legend(fig, axes)


def coefficients(path, rows):
    """The three terms of eq. tfc at the reference system, ours beside the paper's, against H."""
    with figure(path, 9.0, 2.8) as fig:
        for ax, term in zip(fig.subplots(1, 3), "cft", strict=True):
            for shift, (kind, label) in enumerate((("raw", "ours"), ("edge", "ours, edge-corrected"), ("paper", "paper"))):
                chosen = [row for row in rows if row["area"] == kind and row["exponents"] in ("free", "printed")]
                if chosen:
                    ax.errorbar(
                        [row["hurst"] + 0.012 * (shift - 1) for row in chosen],
                        [row[f"term_{term}"] for row in chosen],
                        [row.get(f"term_{term}_se") or 0.0 for row in chosen],
                        color=COLOURS[shift],
                        marker=MARKS[shift],
                        linestyle="",
                        markerfacecolor="white" if kind == "edge" else COLOURS[shift],
                        capsize=2,
                        label=label,
                    )
            ax.axhline(0, color="0.8", linewidth=0.8, zorder=0)
            ax.set(xlabel="$H$", ylabel=f"$C_{term} \\epsilon_{term}^{{\\alpha_{term}}}$ at the reference")
        _legend(fig, fig.axes)


def limits(path, rows):
    """kappa in the TFC limit against H, with the paper, other authors at H = 0.8 and theories."""
    with figure(path, 6.2, 3.4) as fig:
        ax = fig.subplots()
        for kind, open_mark, label in (("raw", False, "ours, as counted"), ("edge", True, "ours, edge-corrected")):
            chosen = [
                row | {"hurst": row["hurst_number"] + (0.008 if open_mark else -0.008)} for row in rows if row.get("area") == kind
            ]
            points(ax, chosen, "hurst", "kappa_tfc", COLOURS[0], "o", open_mark, label)
        points(ax, [row for row in rows if row.get("area") == "paper"], "hurst_number", "kappa_tfc", COLOURS[1], "s", label="paper")
        others = [row for row in rows if row.get("area") == "literature"]
        for row, mark in zip(others, MARKS[2:], strict=False):
            ax.plot(
                0.8,
                row["kappa_08"],
                color=COLOURS[2],
                marker=mark,
                linestyle="",
                markersize=4,
                label=f"{row['authors'].split(',')[0]} {row['year']}",
            )
        ax.axhline(persson.KAPPA_LOW_LOAD, label="Persson", **THEORY)
        ax.axhline(elastic.KAPPA_BGT, linestyle=":", label="BGT", **THEORY)
        ax.set(xlabel="$H$", ylabel=r"$\kappa$ in the TFC limit, $p^* = 0.01/\sqrt{2}$")
        _legend(fig, [ax])


def _keys(ax, rows, edge, families, family):
    """Keys for colours, filled and open marks, and the marks of families."""
    for hurst in sorted({row["hurst"] for row in rows}):
        ax.plot([], [], color=colour(hurst), marker="o", linestyle="", markersize=4, label=f"$H = {hurst:g}$")
    if edge:
        ax.plot([], [], color="0.35", marker="o", linestyle="", markersize=4, label="as counted")
        ax.plot([], [], color="0.35", marker="o", markerfacecolor="white", linestyle="", markersize=4, label="edge-corrected")
    for member, mark in families:
        name = {"lam_l_over_lam_s": r"\epsilon_f", "L_over_lam_l": r"\epsilon_t", "lam_s_over_a": r"\epsilon_c"}[family]
        ax.plot([], [], color="0.35", marker=mark, linestyle="", markersize=4, label=f"${name} = 1/{member:g}$")


def _legend(fig, axes):
    """One legend for all panels, beside them."""
    handles = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    fig.legend(handles.values(), handles.keys(), loc="outside right upper")
