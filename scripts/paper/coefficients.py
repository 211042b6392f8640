"""The rows of the coefficient tables, and our own table in the form of the paper's, for `hpc-gfmd
tfc`."""

import json
from collections.abc import Iterator
from pathlib import Path

from hpc_gfmd.theory.tfc_fit import TfcFit
from hpc_gfmd.util.errors import SceneError

from . import fits, paper
from .levels import PRESSURES, REFERENCE, at_level
from .publish import write_whole
from .rows import Rows, by_hurst, low_high, where
from .text import filled

TERMS = "cft"
FITS = {
    "kappa": (("raw", "kappa"), ("edge", "kappa_edge")),
    "gap_over_h_rms": (("raw", "gap_over_h_rms"),),
}


def table_rows(runs: Rows, level: str, observable: str, pressure: str) -> Rows:
    """For each H: our fits (area "raw" and, for kappa, "edge"; exponents "free" or "paper") and the
    row that the paper prints.

    Columns C_i, alpha_i, limit with NAME_se (None for what is not fitted), term_i = C_i
    eps_i^alpha_i at the reference system, chi2_per_dof, n_runs. pressure: "low" or "high".
    """
    eps = dict(zip("tfc", (1 / ratio for ratio in at_level(REFERENCE, level)), strict=True))
    rows = []
    for hurst, part in by_hurst(low_high(runs)[pressure]).items():
        for area, exponents, fit in _fits(part, level, observable):
            rows.append(
                {"hurst": hurst, "area": area, "exponents": exponents}
                | _columns(fit, eps)
                | {"n_runs": len(part)}
            )
        if printed := paper.coefficients(observable, pressure, hurst):
            rows.append(
                {"hurst": hurst, "area": "paper", "exponents": "printed"}
                | {f"{name}_{i}": printed[f"{name}_{i}"] for name in ("C", "alpha") for i in TERMS}
                | {f"term_{i}": printed[f"C_{i}"] * eps[i] ** printed[f"alpha_{i}"] for i in TERMS}
            )
    return rows


def compare(rows: Rows, observable: str, pressure: str) -> paper.Sayings:
    """Our coefficients beside the paper's: with its exponents where we have such a fit, and with
    ours."""
    theirs, mine = (
        ", ".join(f"C_{i} = {{C_{i}:{how}}} (alpha {{alpha_{i}:{how}}})" for i in TERMS)
        for how in "g±"
    )
    for hurst, part in by_hurst(rows).items():
        printed, ours = where(part, area="paper"), where(part, area="raw")
        if printed and ours:
            paper_sum, our_sum = (
                sum(row[f"term_{i}"] for i in TERMS) for row in (printed[0], ours[0])
            )
            yield paper.saying(
                f"{paper.at(pressure, hurst)}: {filled(theirs, printed[0])}",
                "; ".join(
                    filled(mine, row) for row in sorted(ours, key=lambda row: row["exponents"])
                ),
                f"sum of the terms at the reference system: paper {paper_sum:.3g}, ours"
                f" {our_sum:.3g}"
                + ("; the fractal term is nearly the whole gap" if observable != "kappa" else ""),
            )


def our_table(runs: Rows, level: str) -> dict:
    """A table like paper_tfc.json from our fits with free exponents to the runs of
    levels.tfc_series: kappa as counted, gap/h_rms."""
    tables = []
    for observable in FITS:
        for pressure, part in low_high(runs).items():
            rows = [
                fit.row(hurst)
                for hurst, family in by_hurst(part).items()
                for *kind, fit in _fits(family, level, observable)
                if kind == ["raw", "free"]
            ]
            if rows:
                tables.append(
                    {"observable": observable, "p_star": PRESSURES[pressure], "rows": rows}
                )
    return {
        "source": f"hpc_gfmd, study level {level}",
        "note": (
            "O_sim = O_TFC + C_t eps_t^alpha_t + C_f eps_f^alpha_f + C_c eps_c^alpha_c around the"
            f" reference system (L/lam_l, lam_l/lam_s, lam_s/a) = {REFERENCE[level]}, area as"
            " counted; the terms do not add up far from it. sigma, covariance (in the order of"
            " names): realisations and solver. The limit of gap/h_rms is zero by construction."
        ),
        "tables": tables,
    }


def write_our_table(table: dict, path: str | Path) -> None:
    """Write the table as JSON. Raises OSError."""
    write_whole(path, json.dumps(table, indent=1, allow_nan=False) + "\n")


def _fits(runs: Rows, level: str, observable: str) -> Iterator[tuple[str, str, TfcFit]]:
    """(area, exponents, TfcFit) of all fits that the runs allow."""
    for area, name in FITS[observable]:
        for exponents in ("free", "paper"):
            try:
                yield area, exponents, fits.fit_observable(runs, name, level, exponents == "paper")
            except SceneError:  # the series is not long enough yet
                continue


def _columns(fit: TfcFit, eps: dict[str, float]) -> dict:
    row: dict = {}
    for name, values in (("C", fit.C), ("alpha", fit.alpha)):
        for i in TERMS:
            row |= {f"{name}_{i}": values[i], f"{name}_{i}_se": fit.sigma.get(f"{name}_{i}")}
    row |= {
        "limit": fit.limit,
        "limit_se": fit.sigma.get("limit"),
        "chi2_per_dof": fit.chi2 / fit.dof if fit.dof else None,
    }
    for i in TERMS:
        row[f"term_{i}"], row[f"term_{i}_se"] = fit.correction(**{f"eps_{i}": eps[i]})
    return row
