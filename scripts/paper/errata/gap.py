"""Errata of what the paper says about the mean gap, each shown by the rows of our figures and
tables."""

from collections.abc import Iterator
from typing import Any

from hpc_gfmd.theory import persson

from .. import paper
from ..items import gap
from ..paper import of_hurst
from ..rows import Rows, by_hurst, families, fine_half, finest, low_high
from . import Errata

GAP = "gap_over_h_rms"
ERRATA = Errata()


@ERRATA.add("caption of the second gap table: p* = 0.007", "p* = 0.353, as its label says")
def caption_pressure(tables: dict[str, Rows]) -> Any:
    parts = []
    for pressure, hurst, rows in _printed(tables):
        row = finest(rows, "eps_f")
        low = {r["eps_f"]: r for r in low_high(tables["fig6"])["low"] if r["hurst"] == hurst}.get(
            row["eps_f"]
        )
        if pressure == "high" and low:
            parts.append(
                f"H = {hurst:g}: table {_printed_gap(pressure, row):.3f}; ours {row[GAP]:.4f} at"
                f" 0.353, {low[GAP]:.3f} at 0.007"
            )
    return "; ".join(parts)


@ERRATA.add(
    "gap tables 3 and 4: C_c eps_c + C_f eps_f^alpha_f + C_t eps_t (the limit is zero)",
    "too large at the high pressure",
)
def gap_tables(tables: dict[str, Rows]) -> Any:
    parts = []
    for pressure, hurst, rows in _printed(tables):
        ratios = [_printed_gap(pressure, row) / row[GAP] for row in fine_half(rows)]
        parts.append(
            f"{min(ratios):.2f} to {max(ratios):.2f} (H = {hurst:g}, p* ="
            f" {paper.PRINTED[pressure]})"
        )
    return parts and "printed sum over our gap, finer half of the eps_f: " + ", ".join(parts)


@ERRATA.add(
    "figure 6: the printed theory is 3, 3, 2 times below the simulations (H = 0.3, 0.5, 0.8)",
    "table 4 says something else of the same simulations",
)
def tables_against_captions(tables: dict[str, Rows]) -> Any:
    parts = []
    for pressure, hurst, rows in _printed(tables):
        if pressure == "high":
            ratios = [
                _printed_gap(pressure, row) / row["persson_printed"] for row in fine_half(rows)
            ]
            caption = of_hurst("theory_factor_h_rms", hurst)
            parts.append(
                f"H = {hurst:g}: table {min(ratios):.1f} to {max(ratios):.1f}, caption {caption:g}"
            )
    return parts and "simulation over theory as printed: " + "; ".join(parts)


@ERRATA.add(
    "tables 3 and 4 serve to extrapolate the gap to the TFC limit",
    'gap/h_rms vanishes in the fractal limit: the "correction" is nearly the whole gap',
)
def fractal_term_is_the_gap(tables: dict[str, Rows]) -> Any:
    parts = [
        f"{row['term_f'] / sum(row[f'term_{i}'] for i in 'cft'):.0%} (H = {row['hurst']:g}, p* ="
        f" {paper.PRINTED[pressure]})"
        for table, pressure in (("table3", "low"), ("table4", "high"))
        for row in tables[table]
        if row["area"] == "paper"
    ]
    return (
        parts
        and "share of the fractal term in the printed sum at the reference system: "
        + ", ".join(parts)
    )


@ERRATA.add(
    "gap/(g_rms lam_s) increases with eps_f with exponents 0.25 and 0.75 (p* = 0.007), 0.002 and"
    " 0.14 (0.353)",
    "it decreases: exponents in the two units differ by H, so these are negative",
)
def sign_of_exponents(tables: dict[str, Rows]) -> Any:
    return "; ".join(
        f"{line['paper']}, ours {line['ours']}"
        for line in gap.exponents(tables["fig7"], "g_rms_lam_s")
    )


@ERRATA.add(
    "self-affine between the cutoffs, L/lam_l = 2 (nothing is said of which modes at the cutoffs"
    " are included)",
    "a cell of two lam_l has few long modes: their number changes g_rms lam_s/h_rms, and with it"
    " every gap in units of h_rms",
)
def realised_slope(tables: dict[str, Rows]) -> Any:
    parts, same = [], ("hurst", "p_star", "eps_f", "eps_t", "eps_c")
    for hurst, rows in by_hurst(low_high(tables["fig6"])["low"]).items():
        row = finest(rows, "eps_f")
        if other := next(
            (r for r in tables["fig7"] if all(r[name] == row[name] for name in same)), None
        ):
            realised = row[GAP] / other["gap_over_g_rms_lam_s"]
            parts.append(
                f"{realised / persson.g_rms_lam_s_over_h_rms(hurst, row['eps_f']) - 1:+.1%} (H ="
                f" {hurst:g})"
            )
    return parts and (
        "realised over the integral, both cutoffs included, eps_f ="
        f" 1/{1 / finest(tables['fig6'], 'eps_f')['eps_f']:g}: " + ", ".join(parts)
    )


def _printed(tables: dict[str, Rows]) -> Iterator[tuple]:
    """families of figure 6 for which the paper's tables have coefficients."""
    return (family for family in families(tables["fig6"]) if paper.coefficients(GAP, *family[:2]))


def _printed_gap(pressure: str, row: dict) -> float:
    """The gap at a row's ratios by the paper's table."""
    return paper.correction(
        paper.coefficients(GAP, pressure, row["hurst"]), row["eps_t"], row["eps_f"], row["eps_c"]
    )
