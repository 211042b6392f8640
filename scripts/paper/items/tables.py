"""Tables 1 to 4: coefficients of eq. tfc; table 5 and the limit of kappa, beside other authors'."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from hpc_gfmd import SceneError
from hpc_gfmd.plotting.style import COLOURS

from .. import estimates, printed
from ..cases import CATALOGUE
from ..pictures import MARKS, TITLES, kappa_lines, named, panels, points
from ..printed import NUMBERS, of_hurst
from ..rows import PRESSURES, Rows, by_hurst, each, filled, groups, low_high, saying, where
from ..study import Study

AREAS = {"raw": "", "edge": "_edge"}  # as counted, edge-corrected


def coefficients(runs: Rows, level: str, observable: str, pressure: str) -> Rows:
    """Fit eq. tfc for each H, beside the row that the paper prints.

    area "raw" and, for kappa, "edge"; exponents "free" or "paper". Columns C_i, alpha_i, limit (of
    this law on the axes through the reference system, where its terms do not add up) with NAME_se
    (None for what is not fitted), term_i = C_i eps_i^alpha_i at the reference system, chi2_per_dof.
    """
    eps = {i: 1 / ratio for i, ratio in zip("tfc", CATALOGUE["reference"][level])}
    rows = []
    for hurst, part in by_hurst(low_high(runs)[pressure]).items():
        for area, exponents, fit in _fits(part, level, observable):
            row = {"hurst": hurst, "area": area, "exponents": exponents}
            for name, value in _flat(fit.row(hurst)).items():
                row |= {name: value, f"{name}_se": fit.sigma.get(name)}
            row |= {"chi2_per_dof": fit.chi2 / fit.dof if fit.dof else None, "n_runs": len(part)}
            for i in "cft":
                row[f"term_{i}"], row[f"term_{i}_se"] = fit.correction(**{f"eps_{i}": eps[i]})
            rows.append(row)
        if theirs := printed.coefficients(observable, pressure, hurst):
            row = {"hurst": hurst, "area": "paper", "exponents": "printed"} | _flat(theirs)
            terms = {f"term_{i}": row[f"C_{i}"] * eps[i] ** row[f"alpha_{i}"] for i in "cft"}
            rows.append(row | terms)
    return rows


def _flat(row):
    return {k: v for k, v in row.items() if k[:2] in ("C_", "al", "li")}


def _fits(runs, level, observable):
    """Yield (area, exponents, fit) of all fits that the runs allow."""
    for area, ending in AREAS.items():
        for exponents in ("free", "paper"):
            if f"{observable}{ending}" in runs[0]:
                try:
                    fit = estimates.fit_observable(
                        runs, f"{observable}{ending}", level, exponents == "paper"
                    )
                except SceneError:  # the series is not long enough yet
                    continue
                yield area, exponents, fit


def compare(rows: Rows, observable: str, pressure: str) -> Iterator[dict]:
    """Compare our coefficients, with the paper's exponents where we have those, and with ours."""
    theirs, mine = (
        ", ".join(f"C_{i} = {{C_{i}:{how}}} (alpha {{alpha_{i}:{how}}})" for i in "cft")
        for how in "g±"
    )
    for hurst, part in by_hurst(rows).items():
        paper, ours = where(part, area="paper"), where(part, area="raw")
        if paper and ours:
            sums = [sum(row[f"term_{i}"] for i in "cft") for row in (paper[0], ours[0])]
            yield saying(
                f"{printed.at(pressure, hurst)}: {filled(theirs, paper[0])}",
                each(mine, sorted(ours, key=lambda row: row["exponents"]), "; "),
                "sum of the terms at the reference system: paper {:.3g}, ours {:.3g}".format(*sums),
            )


def our_table(runs: Rows, level: str) -> dict:
    """Make a table like paper_tfc.json from our fits with free exponents, as counted."""
    tables = []
    for observable in ("kappa", "gap_over_h_rms"):
        for pressure, part in low_high(runs).items():
            rows = [
                fit.row(hurst)
                for hurst, family in by_hurst(part).items()
                for *kind, fit in _fits(family, level, observable)
                if kind == ["raw", "free"]
            ]
            if rows:
                one = {"observable": observable, "p_star": PRESSURES[pressure], "rows": rows}
                tables.append(one)
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
                how: Any = {"color": COLOURS[k], "label": label, "hollow": area == "edge"}
                points(ax, chosen, "at", f"term_{term}", MARKS[k], **how)
            ax.axhline(0, color="0.8", linewidth=0.8, zorder=0)
            named(ax, "hurst", f"$C_{term} \\epsilon_{term}^{{\\alpha_{term}}}$ at the reference")


def limit(runs: Rows, level: str) -> Rows:
    """List kappa of other authors, and ours in the limit (estimates.limits) beside the paper's."""
    rows = [{"area": "literature"} | entry for entry in NUMBERS["literature"]]
    for row in estimates.limits(runs):
        theirs = of_hurst("kappa_tfc", row["hurst"]) if row["p_star"] < 0.1 else None
        rows.append({"area": "ours"} | row | {"printed": theirs})
    return rows


def our_limits(rows: Rows) -> Iterator[dict]:
    """Compare our limits with the paper's, and say which statements of the paper survive."""
    ours = where(rows, area="ours")
    for row in ours:
        yield saying(
            "H = {hurst:g}, p* = {p_star:.3g}"
            + (": kappa = {printed:g}" if row["printed"] else ""),
            "kappa = {kappa_tfc:±}; as counted {counted:.4f}, edge-corrected {edge:.4f}",
            f"alpha_f = {{alpha_f:±}}; 2 - 2H = {2 - 2 * row['hurst']:g}"
            f" {'agrees' if row['agrees'] else 'does not'}",
            **row,
        )
    for p_star, part in groups(ours, "p_star").items():
        fall = 1 - part[-1]["kappa_tfc"] / part[0]["kappa_tfc"]
        yield saying(
            f"kappa falls as H grows, p* = {p_star:.3g}",
            f"by {fall:.0%} from the smallest H to the largest",
            "survives" if fall > 0 else "does not survive",
        )
    exponent = NUMBERS["alpha_f"]
    against = [row for row in ours if abs(row["alpha_f"] - exponent) > 2 * row["alpha_f_se"]]
    yield saying(
        f"one exponent alpha_f = {exponent:g} for all H",
        each("{alpha_f:±} at H = {hurst:g}, p* = {p_star:.3g}", against) or "agrees",
        "does not survive: off by more than two standard errors" if against else "survives",
    )


def draw_limits(rows: Rows, path: Path) -> None:
    """Draw kappa in the limit against H, with the paper, other authors at H = 0.8 and theories."""
    with panels(path, 2) as axes:
        for ax, (pressure, part) in zip(axes, low_high(where(rows, area="ours")).items()):
            points(ax, part, "hurst", "kappa_tfc", color=COLOURS[0], label="ours")
            points(ax, part, "hurst", "printed", "s", color=COLOURS[1], label="paper")
            kappa_lines(ax, PRESSURES[pressure])
            named(ax, "hurst", "kappa_tfc", title=TITLES[pressure])
        for row, mark in zip(where(rows, area="literature"), MARKS):
            label = f"{row['authors'].split(',')[0]} {row['year']}"
            at_08 = [row | {"hurst": 0.8}]
            points(axes[0], at_08, "hurst", "kappa_08", mark, color=COLOURS[2], label=label)


def _coefficients(name, observable, pressure):
    what: Any = {"observable": observable, "pressure": pressure}
    return Study(name, partial(coefficients, **what), draw_coefficients, partial(compare, **what))


STUDIES = (
    _coefficients("table1", "kappa", "low"),
    _coefficients("table2", "kappa", "high"),
    _coefficients("table3", "gap_over_h_rms", "low"),
    _coefficients("table4", "gap_over_h_rms", "high"),
    *(Study(name, limit, draw_limits, our_limits) for name in ("table5", "limit")),
)
