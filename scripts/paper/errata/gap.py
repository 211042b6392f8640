"""Errata of what the paper says about the mean gap, each shown by the rows of our items."""

from collections.abc import Iterator
from typing import Any

from hpc_gfmd.theory import persson

from ..items import gap
from ..printed import PRINTED, at, coefficients, correction, of_hurst
from ..rows import Rows, by_hurst, families, fine_half, finest, low_high, where
from .listed import Errata

GAP = "gap_over_h_rms"
ERRATA = Errata()


def _printed(tables: dict[str, Rows]) -> Iterator[tuple[str, float, Rows]]:
    """Yield the families of figure 6 for which the paper's tables have coefficients, with the gap
    that these make as column "table"."""
    for pressure, hurst, rows in families(tables["fig6"]):
        if row := coefficients(GAP, pressure, hurst):
            yield pressure, hurst, [one | {"table": correction(row, one)} for one in rows]


@ERRATA.add("caption of the second gap table: p* = 0.007", "p* = 0.353, as its label says")
def caption_pressure(tables: dict[str, Rows]) -> Any:
    parts, low = [], low_high(tables["fig6"])["low"]
    for pressure, hurst, rows in _printed(tables):
        row = finest(rows, "eps_f")
        for other in where(low, hurst=hurst, eps_f=row["eps_f"]) if pressure == "high" else []:
            parts.append(
                f"H = {hurst:g}: table {row['table']:.3f}; ours {row[GAP]:.4f} at 0.353,"
                f" {other[GAP]:.3f} at 0.007"
            )
    return "; ".join(parts)


@ERRATA.add(
    "gap tables 3 and 4: C_c eps_c + C_f eps_f^alpha_f + C_t eps_t (the limit is zero)",
    "too large at the high pressure",
)
def gap_tables(tables: dict[str, Rows]) -> Any:
    parts = [
        f"{gap.span([row['table'] / row[GAP] for row in fine_half(rows)])} ({at(pressure, hurst)})"
        for pressure, hurst, rows in _printed(tables)
    ]
    return parts and "printed sum over our gap, finer half of the eps_f: " + ", ".join(parts)


@ERRATA.add(
    "figure 6: the printed theory is 3, 3, 2 times below the simulations (H = 0.3, 0.5, 0.8)",
    "table 4 says something else of the same simulations",
)
def tables_against_captions(tables: dict[str, Rows]) -> Any:
    parts = []
    for pressure, hurst, rows in _printed(tables):
        if pressure == "high":
            ratios = [row["table"] / row["persson_printed"] for row in fine_half(rows)]
            caption = of_hurst("theory_factor_h_rms", hurst)
            parts.append(f"H = {hurst:g}: table {gap.span(ratios, 1)}, caption {caption:g}")
    return parts and "simulation over theory as printed: " + "; ".join(parts)


@ERRATA.add(
    "tables 3 and 4 serve to extrapolate the gap to the TFC limit",
    'gap/h_rms vanishes in the fractal limit: the "correction" is nearly the whole gap',
)
def fractal_term_is_the_gap(tables: dict[str, Rows]) -> Any:
    parts = [
        f"{row['term_f'] / sum(row[f'term_{i}'] for i in 'cft'):.0%} (H = {row['hurst']:g}, p* ="
        f" {PRINTED[pressure]})"
        for table, pressure in (("table3", "low"), ("table4", "high"))
        for row in where(tables[table], area="paper")
    ]
    head = "share of the fractal term in the printed sum at the reference system: "
    return parts and head + ", ".join(parts)


@ERRATA.add(
    "gap/(g_rms lam_s) increases with eps_f with exponents 0.25 and 0.75 (p* = 0.007), 0.002 and"
    " 0.14 (0.353)",
    "it decreases: exponents in the two units differ by H, so these are negative",
)
def sign_of_exponents(tables: dict[str, Rows]) -> Any:
    lines = gap.exponents(tables["fig7"], "g_rms_lam_s")
    return "; ".join(f"{line['paper']}, ours {line['ours']}" for line in lines)


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
        for other in where(tables["fig7"], **{name: row[name] for name in same}):
            realised = row[GAP] / other["gap_over_g_rms_lam_s"]
            exact = persson.g_rms_lam_s_over_h_rms(hurst, row["eps_f"])
            parts.append(f"{realised / exact - 1:+.1%} (H = {hurst:g})")
    return parts and (
        "realised over the integral, both cutoffs included, eps_f ="
        f" 1/{1 / finest(tables['fig6'], 'eps_f')['eps_f']:g}: " + ", ".join(parts)
    )
