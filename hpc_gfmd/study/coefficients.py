"""The rows of the coefficient tables, and our own table in the form of the paper's, for `hpc-gfmd tfc`."""

import json

from ..errors import SceneError
from . import fits, paper
from .averages import near
from .levels import level_of
from .publish import write_whole

TERMS = "cft"


def table_rows(runs, level, observable, p_star):
    """For each H: our fits (area "raw" and, for kappa, "edge"; exponents "free" or "paper") and the row that the paper prints.

    Columns C_i, alpha_i, limit with NAME_se (None for what is not fitted), term_i = C_i eps_i^alpha_i at the reference system,
    chi2_per_dof, n_runs.
    """
    rows = []
    for hurst in sorted({run["hurst"] for run in runs}):
        part = [run for run in runs if run["hurst"] == hurst and near(run["p_star"], p_star)]
        for area, exponents, fit in _fits(part, level, observable):
            rows.append({"hurst": hurst, "area": area, "exponents": exponents} | _columns(fit, level) | {"n_runs": len(part)})
        printed = paper.coefficients(observable, p_star, hurst)
        if printed:
            rows.append({"hurst": hurst, "area": "paper", "exponents": "printed"} | _printed_columns(printed, level))
    return rows


def compare(rows, observable, p_star):
    """Our coefficients beside the paper's: with its exponents where we have such a fit, and with ours."""
    lines = []
    for printed in (row for row in rows if row["area"] == "paper"):
        ours = [row for row in rows if row["hurst"] == printed["hurst"] and row["area"] == "raw"]
        if not ours:
            continue
        text = [
            ", ".join(
                f"C_{i} = {paper.quoted(row[f'C_{i}'], row[f'C_{i}_se'])} (alpha "
                f"{paper.quoted(row[f'alpha_{i}'], row[f'alpha_{i}_se'])})"
                for i in TERMS
            )
            for row in sorted(ours, key=lambda row: row["exponents"])
        ]
        total = {id(row): sum(row[f"term_{i}"] for i in TERMS) for row in (printed, ours[0])}
        lines.append(
            paper.saying(
                f"H = {printed['hurst']:g}, p* = {paper.PRINTED[p_star]}: "
                + ", ".join(f"C_{i} = {printed[f'C_{i}']:g} (alpha {printed[f'alpha_{i}']:g})" for i in TERMS),
                "; ".join(text),
                f"sum of the terms at the reference system: paper {total[id(printed)]:.3g}, ours {total[id(ours[0])]:.3g}"
                + ("; the fractal term is nearly the whole gap" if observable != "kappa" else ""),
            )
        )
    return lines


def our_table(runs, level):
    """A table like paper_tfc.json from our fits with free exponents to the runs of levels.tfc_series: kappa as counted, gap/h_rms."""
    tables = []
    for observable in ("kappa", "gap_over_h_rms"):
        for p_star in paper.PRINTED:
            rows = []
            for hurst in sorted({run["hurst"] for run in runs}):
                part = [run for run in runs if run["hurst"] == hurst and near(run["p_star"], p_star)]
                rows += [
                    fit.row(hurst) for area, exponents, fit in _fits(part, level, observable) if (area, exponents) == ("raw", "free")
                ]
            if rows:
                tables.append({"observable": observable, "p_star": p_star, "rows": rows})
    return {
        "source": f"hpc_gfmd, study level {level}",
        "note": "O_sim = O_TFC + C_t eps_t^alpha_t + C_f eps_f^alpha_f + C_c eps_c^alpha_c around the reference system "
        f"(L/lam_l, lam_l/lam_s, lam_s/a) = {level_of(level).reference}, area as counted; the terms do not add up far from it. "
        "sigma, covariance (in the order of names): realisations and solver. The limit of gap/h_rms is zero by construction.",
        "tables": tables,
    }


def write_our_table(table, path):
    """Write the table as JSON. Raises OSError."""
    write_whole(path, json.dumps(table, indent=1, allow_nan=False) + "\n")


def _fits(runs, level, observable):
    """(area, exponents, TfcFit) of all fits that the runs allow."""
    if observable == "kappa":
        wanted = [(area, exponents) for area in ("raw", "edge") for exponents in ("free", "paper")]
    else:
        wanted = [("raw", exponents) for exponents in ("free", "paper")]
    for area, exponents in wanted:
        name = "kappa_edge" if area == "edge" else observable
        try:
            if observable == "kappa":
                yield area, exponents, fits.fit_kappa(runs, name, level, exponents == "paper")
            else:
                yield area, exponents, fits.fit_gap(runs, name, level, exponents == "paper")
        except SceneError:  # the series is not long enough yet
            continue


def _columns(fit, level):
    eps = _reference(level)
    row = {}
    for name, values in (("C", fit.C), ("alpha", fit.alpha)):
        for i in TERMS:
            row |= {f"{name}_{i}": values[i], f"{name}_{i}_se": fit.sigma.get(f"{name}_{i}")}
    row |= {"limit": fit.limit, "limit_se": fit.sigma.get("limit"), "chi2_per_dof": fit.chi2 / fit.dof if fit.dof else None}
    for i in TERMS:
        value, sigma = fit.correction(**{f"eps_{i}": eps[i]})
        row |= {f"term_{i}": value, f"term_{i}_se": sigma}
    return row


def _printed_columns(printed, level):
    eps = _reference(level)
    row = {f"{name}_{i}": printed[f"{name}_{i}"] for name in ("C", "alpha") for i in TERMS}
    return row | {f"term_{i}": printed[f"C_{i}"] * eps[i] ** printed[f"alpha_{i}"] for i in TERMS}


def _reference(level):
    return dict(zip("tfc", (1 / x for x in level_of(level).reference), strict=True))
