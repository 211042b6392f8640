"""What several figures say beside the paper: exponents, ratios to Persson's theory, scatter. All from rows, nothing typed in."""

import numpy as np

from ..theory import persson
from . import fits, paper
from .averages import low_high
from .levels import P_HIGH, P_LOW
from .paper import of_hurst, quoted, saying

PRESSURE = {"low": P_LOW, "high": P_HIGH}
PRINTED = {name: f"p* = {paper.PRINTED[p]}" for name, p in PRESSURE.items()}
HIGHEST = 0.25  # p* from which on it is "the highest" that the paper excepts
_UNIT = {"gap_over_h_rms": "h_rms", "gap_over_g_rms_lam_s": "g_rms_lam_s"}


def with_theory(rows, observable="gap_over_h_rms"):
    """The rows of a gap with Persson's, corrected and as printed, and the ratios of simulation to both."""
    for row in rows:
        how = {"p_star": row["p_star"], "hurst": row["hurst"], "eps_f": row["eps_f"], "unit": _UNIT[observable]}
        row["persson"], row["persson_printed"] = (float(persson.mean_gap(**how, printed=printed)) for printed in (False, True))
        for name in ("persson", "persson_printed"):
            row[f"over_{name}"] = row[observable] / row[name] if row[name] > 0 else None
    return rows


def by_hurst(rows):
    """{H: rows}, in the order of H."""
    return {hurst: [row for row in rows if row["hurst"] == hurst] for hurst in sorted({row["hurst"] for row in rows})}


def finest(rows, ratio):
    """The row with the smallest value of eps_c, eps_f or eps_t; None of no rows."""
    return min(rows, key=lambda row: row[ratio], default=None)


def coarsest(rows, ratio):
    """The row with the largest value of a ratio; None of no rows."""
    return max(rows, key=lambda row: row[ratio], default=None)


def longest(rows, ratio, family):
    """Of the families of rows that share the column `family`, the one with most values of `ratio`; [] of no rows."""
    families = {row[family]: [r for r in rows if r[family] == row[family]] for row in rows}
    return max(families.values(), key=lambda part: len({row[ratio] for row in part}), default=[])


def fine_half(rows):
    """Rows of the finer half of the eps_f, where the paper's power laws are meant to hold."""
    octaves = sorted({row["eps_f"] for row in rows})
    return [row for row in rows if row["eps_f"] <= octaves[len(octaves) // 2]] if octaves else []


def gap_exponents(rows, observable, table):
    """The exponents of eps_f beside those of the paper. In the unit g_rms lam_s, those in the unit h_rms less H are expected."""
    lines = []
    for pressure, part in low_high(rows).items():
        for hurst, chosen in by_hurst(part).items():
            alpha, sigma = fits.power_law(fine_half(chosen), "eps_f", observable)
            printed = of_hurst(table, hurst, pressure)
            if alpha is None or printed is None:
                continue
            if observable == "gap_over_h_rms":
                why = "ours: the finer half of the octaves; the exponent still changes with eps_f"
            else:
                expected = of_hurst("gap_exponents_h_rms", hurst, pressure) - hurst
                why = (
                    f"exponents in the two units differ by H, so the paper's own in units of h_rms makes this one {expected:+.3f}; "
                    "negative: the gap in units of g_rms lam_s rises as eps_f falls"
                )
            lines.append(saying(f"H = {hurst:g}, {PRINTED[pressure]}: exponent of eps_f {printed:g}", quoted(alpha, sigma), why))
    return lines


def theory_factors(rows, table):
    """By how much Persson's theory is too small at the high pressure: as printed, corrected, and what the missing factor explains."""
    lines = []
    for hurst, part in by_hurst(low_high(rows)["high"]).items():
        ratios = {
            name: [row[f"over_{name}"] for row in fine_half(part) if row[f"over_{name}"]] for name in ("persson", "persson_printed")
        }
        if not ratios["persson"]:
            continue
        explained = share_explained(part)
        lines.append(
            saying(
                f"H = {hurst:g}, {PRINTED['high']}: theory {of_hurst(table, hurst) or 0:g} times too small",
                f"{_span(ratios['persson_printed'])} times as printed, {_span(ratios['persson'])} times corrected",
                f"the missing factor 2 in the second term explains {explained:.0%} of the logarithm of our ratio"
                if explained is not None
                else "",
            )
        )
    return lines


def share_explained(rows):
    """How much of ln(simulation/theory) the missing factor of 2 accounts for, mean over the finer half of the rows; None of no rows."""
    part = [row for row in fine_half(rows) if row["over_persson"] and row["over_persson_printed"]]
    logs = [np.log(row["over_persson_printed"] / row["over_persson"]) / np.log(row["over_persson_printed"]) for row in part]
    return float(np.mean(logs)) if logs else None


def gap_curves(rows):
    """How well theory and simulation agree on p* against gap at one H, without the highest loads."""
    within = paper.numbers()["theory_within"]["curves"]
    chosen = [row for row in rows if row["p_star"] < HIGHEST and row["over_persson"] and row["over_persson_printed"]]
    if not chosen:
        return []
    parts = []
    for name, label in (("persson", "corrected"), ("persson_printed", "as printed")):
        ratios = [row[f"over_{name}"] for row in chosen]
        share = sum(abs(ratio - 1) <= within for ratio in ratios) / len(ratios)
        parts.append(f"{label}: {share:.0%} of the loads within {within:.0%}, simulation/theory {min(ratios):.2f} to {max(ratios):.2f}")
    return [
        saying(
            f"H = {chosen[0]['hurst']:g}: theory within {within:.0%} over almost the whole range, except for the highest p*",
            "; ".join(parts),
            f"loads below p* = {HIGHEST:g}; printed and corrected differ by the missing factor 2",
        )
    ]


def relative_scatter(row, observable):
    """Scatter of single realisations over the mean, from the standard error; None where it is not known."""
    se = row.get(f"{observable}_se")
    return se * row["n_seeds"] ** 0.5 / abs(row[observable]) if se is not None else None


def _span(values):
    low, high = f"{min(values):.2f}", f"{max(values):.2f}"
    return low if low == high else f"{low} to {high}"
