"""Errata of what the paper says about the mean gap, each shown by the rows of our figures and tables.

Every function takes {study: rows} and returns {"printed", "right", "shown"}, or None where the rows do not reach that far yet.
"""

from ..theory import persson
from . import paper
from .averages import low_high
from .compare import by_hurst, fine_half, finest
from .errata_method import erratum
from .items import fig7
from .levels import P_HIGH, P_LOW
from .paper import of_hurst


def caption_pressure(tables):
    """The caption of the second gap table."""
    parts = []
    for hurst, rows in by_hurst(tables["fig6"]).items():
        printed = paper.coefficients("gap_over_h_rms", P_HIGH, hurst)
        if printed is None:
            continue
        row = finest(low_high(rows)["high"], "eps_f")
        low = next((r for r in low_high(rows)["low"] if row and r["eps_f"] == row["eps_f"]), None)
        if low:
            claim = _printed_gap(printed, row)
            parts.append(
                f"H = {hurst:g}: table {claim:.3f}; ours {row['gap_over_h_rms']:.4f} at 0.353, {low['gap_over_h_rms']:.3f} at 0.007"
            )
    return parts and erratum("caption of the second gap table: p* = 0.007", "p* = 0.353, as its label says", "; ".join(parts))


def gap_tables(tables):
    """The gap tables against our gaps, at all eps_f solved."""
    parts = []
    for pressure, rows in low_high(tables["fig6"]).items():
        for hurst, chosen in by_hurst(rows).items():
            printed = paper.coefficients("gap_over_h_rms", P_LOW if pressure == "low" else P_HIGH, hurst)
            if printed:
                ratios = [_printed_gap(printed, row) / row["gap_over_h_rms"] for row in fine_half(chosen)]
                parts.append(
                    f"{min(ratios):.2f} to {max(ratios):.2f} (H = {hurst:g}, p* = "
                    f"{paper.PRINTED[P_LOW if pressure == 'low' else P_HIGH]})"
                )
    return parts and erratum(
        "gap tables 3 and 4: C_c eps_c + C_f eps_f^alpha_f + C_t eps_t (the limit is zero)",
        "too large at the high pressure",
        "printed sum over our gap, finer half of the eps_f: " + ", ".join(parts),
    )


def tables_against_captions(tables):
    """The gap table against the factors that the captions give for the same simulations."""
    parts = []
    for hurst, rows in by_hurst(low_high(tables["fig6"])["high"]).items():
        printed = paper.coefficients("gap_over_h_rms", P_HIGH, hurst)
        if printed:
            ratios = [_printed_gap(printed, row) / row["persson_printed"] for row in fine_half(rows)]
            parts.append(
                f"H = {hurst:g}: table {min(ratios):.1f} to {max(ratios):.1f}, caption {of_hurst('theory_factor_h_rms', hurst):g}"
            )
    return parts and erratum(
        "figure 6: the printed theory is 3, 3, 2 times below the simulations (H = 0.3, 0.5, 0.8)",
        "table 4 says something else of the same simulations",
        "simulation over theory as printed: " + "; ".join(parts),
    )


def fractal_term_is_the_gap(tables):
    """The fractal "correction" of the gap tables."""
    parts = []
    for name, p_star in (("table3", P_LOW), ("table4", P_HIGH)):
        for row in tables[name]:
            if row["area"] == "paper":
                total = sum(row[f"term_{i}"] for i in "cft")
                parts.append(f"{row['term_f'] / total:.0%} (H = {row['hurst']:g}, p* = {paper.PRINTED[p_star]})")
    return parts and erratum(
        "tables 3 and 4 serve to extrapolate the gap to the TFC limit",
        'gap/h_rms vanishes in the fractal limit: the "correction" is nearly the whole gap',
        "share of the fractal term in the printed sum at the reference system: " + ", ".join(parts),
    )


def sign_of_exponents(tables):
    """The exponents of the gap in units of g_rms lam_s."""
    lines = fig7.compare(tables["fig7"])
    parts = [f"{line['paper']}, ours {line['ours']}" for line in lines if "exponent" in line["paper"]]
    return parts and erratum(
        "gap/(g_rms lam_s) increases with eps_f with exponents 0.25 and 0.75 (p* = 0.007), 0.002 and 0.14 (0.353)",
        "it decreases: exponents in the two units differ by H, so these are negative",
        "; ".join(parts),
    )


def realised_slope(tables):
    """g_rms lam_s/h_rms of the surfaces that were solved."""
    parts = []
    for hurst, rows in by_hurst(low_high(tables["fig6"])["low"]).items():
        row = finest(rows, "eps_f")
        other = next((r for r in tables["fig7"] if all(r[k] == row[k] for k in ("hurst", "p_star", "eps_f", "eps_t", "eps_c"))), None)
        if other:
            realised = row["gap_over_h_rms"] / other["gap_over_g_rms_lam_s"]
            parts.append(f"{realised / persson.g_rms_lam_s_over_h_rms(hurst, row['eps_f']) - 1:+.1%} (H = {hurst:g})")
    return parts and erratum(
        "self-affine between the cutoffs, L/lam_l = 2 (nothing is said of which modes at the cutoffs are included)",
        "a cell of two lam_l has few long modes: their number changes g_rms lam_s/h_rms, and with it every gap in units of h_rms",
        f"realised over the integral, both cutoffs included, eps_f = 1/{1 / finest(tables['fig6'], 'eps_f')['eps_f']:g}: "
        + ", ".join(parts),
    )


def _printed_gap(coefficients, row):
    return sum(coefficients[f"C_{i}"] * row[f"eps_{i}"] ** coefficients[f"alpha_{i}"] for i in "cft")


ERRATA = (caption_pressure, gap_tables, tables_against_captions, fractal_term_is_the_gap, sign_of_exponents, realised_slope)
