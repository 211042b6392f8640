"""Tables 1 to 4: coefficients of eq. tfc. Table 5 and the limit of kappa, with other authors."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from hpc_gfmd import SceneError
from hpc_gfmd.plotting.style import COLOURS

from .. import estimates, printed
from ..cases import CATALOGUE
from ..pictures import MARKS, TITLES, draw_kappa_theory, draw_points, label_axes, panels
from ..printed import NUMBERS, of_hurst
from ..rows import (
    PRESSURES,
    Rows,
    by_hurst,
    comparison,
    filled,
    filled_with_each,
    groups,
    low_high,
    where,
)
from ..study import Study

AREAS = {"raw": "", "edge": "_edge"}  # suffix of the column: as counted, edge-corrected


def coefficients(runs: Rows, level: str, observable: str, pressure: str) -> Rows:
    """Fit eq. tfc at a pressure ("low" or "high") for each H, and add the row that the paper
    prints.

    Rows differ in area ("raw" and, for kappa, "edge"; "paper") and exponents ("free" or "paper";
    "printed"). C_i, alpha_i and limit (of this law on the axes through the reference system, where
    its terms do not add up) with NAME_se (None if not fitted); term_i = C_i eps_i^alpha_i at the
    reference system.
    """
    eps = {i: 1 / ratio for i, ratio in zip("tfc", CATALOGUE["reference"][level])}
    rows = []
    for hurst, part in by_hurst(low_high(runs)[pressure]).items():
        for area, exponents, fit in _fits(part, level, observable):
            row = {"hurst": hurst, "area": area, "exponents": exponents}
            for name, value in _parameters(fit.row(hurst)).items():
                row |= {name: value, f"{name}_se": fit.sigma.get(name)}
            row |= {"chi2_per_dof": fit.chi2 / fit.dof if fit.dof else None, "n_runs": len(part)}
            for i in "cft":
                row[f"term_{i}"], row[f"term_{i}_se"] = fit.correction(**{f"eps_{i}": eps[i]})
            rows.append(row)
        if theirs := printed.coefficients(observable, pressure, hurst):
            row = {"hurst": hurst, "area": "paper", "exponents": "printed"} | _parameters(theirs)
            terms = {f"term_{i}": row[f"C_{i}"] * eps[i] ** row[f"alpha_{i}"] for i in "cft"}
            rows.append(row | terms)
    return rows


def _parameters(row):
    """Return C_i, alpha_i and limit of a row."""
    return {key: row[key] for key in row if key.startswith(("C_", "alpha_", "limit"))}


def _fits(runs, level, observable):
    """Yield (area, exponents, fit) of all fits for which there are enough runs."""
    for area, suffix in AREAS.items():
        for exponents in ("free", "paper"):
            fit = _fit(runs, level, f"{observable}{suffix}", exponents)
            if fit is not None:
                yield area, exponents, fit


def _fit(runs, level, column, exponents):
    """Fit eq. tfc to a column of runs at one H and p*; None if the series are too short."""
    if column not in runs[0]:
        return None
    try:
        return estimates.fit_observable(runs, column, level, printed=exponents == "paper")
    except SceneError:
        return None


def compare(rows: Rows, observable: str, pressure: str) -> Iterator[dict]:
    """Compare our coefficients, rows of `coefficients`, with the paper's."""
    their_template, our_template = (
        ", ".join(f"C_{i} = {{C_{i}:{form}}} (alpha {{alpha_{i}:{form}}})" for i in "cft")
        for form in "g±"
    )
    for hurst, part in by_hurst(rows).items():
        paper = where(part, area="paper")
        ours = where(part, area="raw")
        if paper and ours:
            sums = [sum(row[f"term_{i}"] for i in "cft") for row in (paper[0], ours[0])]
            ordered = sorted(ours, key=lambda row: row["exponents"])
            yield comparison(
                f"{printed.family_label(pressure, hurst)}: {filled(their_template, paper[0])}",
                filled_with_each(our_template, ordered, "; "),
                "sum of the terms at the reference system: paper {:.3g}, ours {:.3g}".format(*sums),
            )


def our_table(runs: Rows, level: str) -> dict:
    """Return a table like paper_tfc.json of our fits with free exponents, area as counted."""
    tables = []
    for observable in ("kappa", "gap_over_h_rms"):
        for pressure, part in low_high(runs).items():
            fits = {
                hurst: _fit(family, level, observable, "free")
                for hurst, family in by_hurst(part).items()
            }
            rows = [fit.row(hurst) for hurst, fit in fits.items() if fit is not None]
            if rows:
                p_star = PRESSURES[pressure]
                tables.append({"observable": observable, "p_star": p_star, "rows": rows})
    return {
        "source": f"hpc_gfmd, study level {level}",
        "note": (
            "O_sim = O_TFC + C_t eps_t^alpha_t + C_f eps_f^alpha_f + C_c eps_c^alpha_c around the"
            f" reference system (L/lam_l, lam_l/lam_s, lam_s/a) = {CATALOGUE['reference'][level]},"
            " area as counted; the terms do not add up far from it. sigma, covariance (in the order"
            " of names): realisations and solver. The limit of gap/h_rms is zero by construction."
        ),
        "tables": tables,
    }


def draw_coefficients(rows: Rows, path: Path) -> None:
    """Draw the three terms of eq. tfc at the reference system, ours beside the paper's."""
    kinds = (("raw", "ours"), ("edge", "ours, edge-corrected"), ("paper", "paper"))
    with panels(path, 3) as axes:
        for ax, term in zip(axes, "cft"):
            for k, (area, label) in enumerate(kinds):
                chosen = [
                    row | {"at": row["hurst"] + 0.012 * (k - 1)}
                    for row in where(rows, area=area)
                    if row["exponents"] != "paper"
                ]
                style: Any = {"color": COLOURS[k], "label": label, "is_open": area == "edge"}
                draw_points(ax, chosen, "at", f"term_{term}", MARKS[k], **style)
            ax.axhline(0, color="0.8", linewidth=0.8, zorder=0)
            label_axes(
                ax, "hurst", f"$C_{term} \\epsilon_{term}^{{\\alpha_{term}}}$ at the reference"
            )


def limit(runs: Rows, level: str) -> Rows:
    """Return kappa of other authors, and ours in the limit (estimates.limits) with the paper's."""
    rows = [{"area": "literature"} | entry for entry in NUMBERS["literature"]]
    for row in estimates.limits(runs):
        theirs = of_hurst("kappa_tfc", row["hurst"]) if row["p_star"] < 0.1 else None
        rows.append({"area": "ours"} | row | {"printed": theirs})
    return rows


def our_limits(rows: Rows) -> Iterator[dict]:
    """Compare our limits with the paper's and report which of its statements survive."""
    ours = where(rows, area="ours")
    for row in ours:
        yield comparison(
            "H = {hurst:g}, p* = {p_star:.3g}"
            + (": kappa = {printed:g}" if row["printed"] else ""),
            "kappa = {kappa_tfc:±}; as counted {counted:.4f}, edge-corrected {edge:.4f}",
            f"alpha_f = {{alpha_f:±}}; 2 - 2H = {2 - 2 * row['hurst']:g}"
            f" {'agrees' if row['agrees'] else 'does not'}",
            **row,
        )
    for p_star, part in groups(ours, "p_star").items():
        fall = 1 - part[-1]["kappa_tfc"] / part[0]["kappa_tfc"]
        yield comparison(
            f"kappa falls as H grows, p* = {p_star:.3g}",
            f"by {fall:.0%} from the smallest H to the largest",
            "survives" if fall > 0 else "does not survive",
        )
    exponent = NUMBERS["alpha_f"]
    different = [row for row in ours if abs(row["alpha_f"] - exponent) > 2 * row["alpha_f_se"]]
    yield comparison(
        f"one exponent alpha_f = {exponent:g} for all H",
        filled_with_each("{alpha_f:±} at H = {hurst:g}, p* = {p_star:.3g}", different) or "agrees",
        "does not survive: off by more than two standard errors" if different else "survives",
    )


def draw_limits(rows: Rows, path: Path) -> None:
    """Draw kappa in the limit against H, with the paper, other authors (H = 0.8) and theories."""
    with panels(path, 2) as axes:
        for ax, (pressure, part) in zip(axes, low_high(where(rows, area="ours")).items()):
            draw_points(ax, part, "hurst", "kappa_tfc", color=COLOURS[0], label="ours")
            draw_points(ax, part, "hurst", "printed", "s", color=COLOURS[1], label="paper")
            draw_kappa_theory(ax, PRESSURES[pressure])
            label_axes(ax, "hurst", "kappa_tfc", title=TITLES[pressure])
        for row, mark in zip(where(rows, area="literature"), MARKS):
            label = f"{row['authors'].split(',')[0]} {row['year']}"
            rows_at_08 = [row | {"hurst": 0.8}]
            style = {"color": COLOURS[2], "label": label}
            draw_points(axes[0], rows_at_08, "hurst", "kappa_08", mark, **style)


def _coefficient_study(name, observable, pressure):
    family: Any = {"observable": observable, "pressure": pressure}
    tabulate = partial(coefficients, **family)
    return Study(name, tabulate, draw_coefficients, partial(compare, **family))


STUDIES = (
    _coefficient_study("table1", "kappa", "low"),
    _coefficient_study("table2", "kappa", "high"),
    _coefficient_study("table3", "gap_over_h_rms", "low"),
    _coefficient_study("table4", "gap_over_h_rms", "high"),
    *(Study(name, limit, draw_limits, our_limits) for name in ("table5", "limit")),
)
