"""Errata of the paper's statements about the mean gap, shown with the rows of our items."""

from typing import Any

from hpc_gfmd.theory import persson

from ..items import gap
from ..printed import PRINTED, coefficients, correction, family_label, of_hurst
from ..rows import Rows, by_hurst, families, fine_half, finest, low_high, where

GAP = "gap_over_h_rms"


def _families_with_table(tables):
    """Yield the families of figure 6 for which the paper's tables have coefficients.

    Column "table" is the gap that follows from these.
    """
    for pressure, hurst, rows in families(tables["fig6"]):
        if row := coefficients(GAP, pressure, hurst):
            yield pressure, hurst, [run | {"table": correction(row, run)} for run in rows]


def caption_pressure(tables: dict[str, Rows]) -> Any:
    low = low_high(tables["fig6"])["low"]
    parts = []
    for pressure, hurst, rows in _families_with_table(tables):
        if pressure == "low":
            continue
        row = finest(rows, "eps_f")
        for low_row in where(low, hurst=hurst, eps_f=row["eps_f"]):
            parts.append(
                f"H = {hurst:g}: table {row['table']:.3f}; ours {row[GAP]:.4f} at 0.353,"
                f" {low_row[GAP]:.3f} at 0.007"
            )
    return "; ".join(parts)


def gap_tables(tables: dict[str, Rows]) -> Any:
    parts = [
        f"{gap.span([row['table'] / row[GAP] for row in fine_half(rows)])}"
        f" ({family_label(pressure, hurst)})"
        for pressure, hurst, rows in _families_with_table(tables)
    ]
    return parts and "printed sum over our gap, finer half of the eps_f: " + ", ".join(parts)


def tables_against_captions(tables: dict[str, Rows]) -> Any:
    parts = []
    for pressure, hurst, rows in _families_with_table(tables):
        if pressure == "high":
            ratios = [row["table"] / row["persson_printed"] for row in fine_half(rows)]
            caption = of_hurst("theory_factor_h_rms", hurst)
            parts.append(f"H = {hurst:g}: table {gap.span(ratios, 1)}, caption {caption:g}")
    return parts and "simulation over theory as printed: " + "; ".join(parts)


def fractal_term_is_the_gap(tables: dict[str, Rows]) -> Any:
    parts = [
        f"{row['term_f'] / sum(row[f'term_{i}'] for i in 'cft'):.0%} (H = {row['hurst']:g}, p* ="
        f" {PRINTED[pressure]})"
        for table, pressure in (("table3", "low"), ("table4", "high"))
        for row in where(tables[table], area="paper")
    ]
    head = "share of the fractal term in the printed sum at the reference system: "
    return parts and head + ", ".join(parts)


def sign_of_exponents(tables: dict[str, Rows]) -> Any:
    lines = gap.exponents(tables["fig7"], "g_rms_lam_s")
    return "; ".join(f"{line['paper']}, ours {line['ours']}" for line in lines)


def realised_slope(tables: dict[str, Rows]) -> Any:
    keys = ("hurst", "p_star", "eps_f", "eps_t", "eps_c")
    parts = []
    for hurst, rows in by_hurst(low_high(tables["fig6"])["low"]).items():
        row = finest(rows, "eps_f")
        for row_of_fig7 in where(tables["fig7"], **{name: row[name] for name in keys}):
            realised = row[GAP] / row_of_fig7["gap_over_g_rms_lam_s"]
            exact = persson.g_rms_lam_s_over_h_rms(hurst, row["eps_f"])
            parts.append(f"{realised / exact - 1:+.1%} (H = {hurst:g})")
    return parts and (
        "realised over the integral, both cutoffs included, eps_f ="
        f" 1/{1 / finest(tables['fig6'], 'eps_f')['eps_f']:g}: " + ", ".join(parts)
    )
