"""Figures 4 to 8: the mean gap against eps_c, eps_t and eps_f at the two pressures of the paper."""

from collections.abc import Iterator
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from hpc_gfmd.theory import persson

from .. import printed
from ..estimates import average, power_law
from ..pictures import gap_theory, two_pressures
from ..printed import NUMBERS, of_hurst
from ..rows import (
    PRESSURES,
    Rows,
    by_hurst,
    coarsest,
    comparison,
    families,
    fine_half,
    finest,
    longest,
    low_high,
    near,
    quoted,
)
from ..study import Study

GAP = "gap_over_h_rms"
FIG8_EPS_F = (1e-16, 0.5)  # range of the theory in figure 8
CONVERGED = 0.1  # relative distance to the fractal limit that counts as converged
THEORIES = (("persson", False), ("persson_printed", True))  # (column, as printed)


def means(runs: Rows, level: str) -> Rows:
    """Average gap/h_rms over realisations."""
    return average(runs, GAP)


def with_theory(runs: Rows, level: str = "", unit: str = "h_rms") -> Rows:
    """Average the gap in a unit, h_rms or g_rms_lam_s, and add that of Persson's theory, corrected
    and as printed (persson, persson_printed), and the simulation over them (over_NAME)."""
    rows = average(runs, f"gap_over_{unit}")
    for row in rows:
        arguments = (row["p_star"], row["hurst"], row["eps_f"])
        for name, as_printed in THEORIES:
            gap = float(persson.mean_gap(*arguments, printed=as_printed, unit=unit))
            row[name] = gap
            row[f"over_{name}"] = row[f"gap_over_{unit}"] / gap if gap > 0 else None
    return rows


def share_explained(rows: Rows) -> float | None:
    """Return the share of ln(simulation/theory) that the missing factor of 2 explains.

    It is averaged over the finer half of the rows; None without rows.
    """
    ratios = [[row["over_persson"], row["over_persson_printed"]] for row in fine_half(rows)]
    logs = [np.log(b / a) / np.log(b) for a, b in ratios if a and b]
    return float(np.mean(logs)) if logs else None


def coarse_grid(rows: Rows) -> Iterator[dict]:
    """Compare how much a coarse grid changes the gap at the high pressure."""
    for hurst, family in by_hurst(low_high(rows)["high"]).items():
        ratio = of_hurst("gap_ratio_eps_c", hurst)
        series = longest(family, "eps_c")
        if ratio and len(series) > 1:
            best = finest(series, "eps_c")
            yield comparison(
                f"{printed.family_label('high', hurst)}: gap {ratio:g} times the limit at"
                " eps_c = 1/2",
                "{ratio:.4f} times that at eps_c = {eps_c:1/} (lam_l/lam_s = {lam_l_over_lam_s:g})",
                "the same surfaces on finer grids: this is what the grid alone does",
                **best,
                ratio=coarsest(series, "eps_c")[GAP] / best[GAP],
            )


def finite_size(rows: Rows) -> Iterator[dict]:
    """Compare the sign and size of the finite-size correction."""
    for pressure, hurst, family in families(rows):
        row = printed.coefficients(GAP, pressure, hurst)
        series = longest(family, "eps_t")
        if row and len(series) > 1:
            small = coarsest(series, "eps_t")
            large = finest(series, "eps_t")
            slope = (small[GAP] - large[GAP]) / (small["eps_t"] - large["eps_t"])
            yield comparison(
                f"{printed.family_label(pressure, hurst)}: C_t = {row['C_t']:g}",
                f"{slope:+.3g} from eps_t = {small['eps_t']:g} to {large['eps_t']:g} (lam_l/lam_s ="
                " {lam_l_over_lam_s:g})",
                "the few longest waves make h_rms, and scatter most",
                **small,
            )


def exponents(rows: Rows, unit: str) -> Iterator[dict]:
    """Compare the exponents of eps_f for the gap in a unit, h_rms or g_rms_lam_s.

    In units of g_rms lam_s the exponents are those in units of h_rms minus H.
    """
    for pressure, hurst, family in families(rows):
        alpha, sigma = power_law(fine_half(family), "eps_f", f"gap_over_{unit}")
        claim = of_hurst(f"gap_exponents_{unit}", hurst, pressure)
        if alpha is None or claim is None:
            continue
        why = "ours: the finer half of the octaves; the exponent still changes with eps_f"
        if unit == "g_rms_lam_s":
            expected = of_hurst("gap_exponents_h_rms", hurst, pressure) - hurst
            why = (
                "exponents in the two units differ by H, so the paper's own in units of h_rms makes"
                f" this one {expected:+.3f}"
            )
        yield comparison(
            f"{printed.family_label(pressure, hurst)}: exponent of eps_f {claim:g}",
            quoted(alpha, sigma),
            why,
        )


def theory_factors(rows: Rows, unit: str) -> Iterator[dict]:
    """Compare the factor by which Persson's theory is too small at the high pressure, for the gap
    in a unit."""
    for hurst, part in by_hurst(low_high(rows)["high"]).items():
        if (explained := share_explained(part)) is not None:
            claim = of_hurst(f"theory_factor_{unit}", hurst)
            as_printed, corrected = (
                span([row[f"over_{name}"] for row in fine_half(part) if row[f"over_{name}"]])
                for name in ("persson_printed", "persson")
            )
            yield comparison(
                f"{printed.family_label('high', hurst)}: theory {claim:g} times too small",
                f"{as_printed} times as printed, {corrected} times corrected",
                f"the missing factor 2 explains {explained:.0%} of the logarithm of our ratio",
            )


def decades_needed(rows: Rows) -> Iterator[dict]:
    """Compare how many decades of roughness the fractal limit needs at the low pressure."""
    claim = NUMBERS["decades_to_fractal_limit"]
    if not any(near(row["hurst"], claim["hurst"]) for row in low_high(rows)["low"]):
        return

    def relative_gap(decades):
        gap, limit = (
            float(persson.mean_gap(PRESSURES["low"], claim["hurst"], eps_f, unit="g_rms_lam_s"))
            for eps_f in (10.0**-decades, 1e-60)
        )
        return gap / limit

    needed = next(d for d in np.arange(1, 41) / 2 if relative_gap(d) >= 1 - CONVERGED)
    yield comparison(
        f"H = {claim['hurst']:g}, a_r of order 0.01: self-affine over {claim['decades']} decades"
        " until the gap has its fractal limit",
        f"corrected theory: within {CONVERGED:.0%} after {needed:g} decades; after three it has"
        f" {relative_gap(3):.1g} of it",
        "no simulation can show the limit; theory that fits the data at large eps_f says where it"
        " lies",
    )


def span(values: list[Any], digits: int = 2) -> str:
    """Return the range of values as text, "1.08 to 1.10"."""
    low = f"{min(values):.{digits}f}"
    high = f"{max(values):.{digits}f}"
    return low if low == high else f"{low} to {high}"


def _against_theory(name, unit, eps_f_range=()):
    """Return the study of the gap in a unit against eps_f.

    The theory is drawn over eps_f_range, or about that of the data.
    """

    def compare(rows):
        return chain(exponents(rows, unit), theory_factors(rows, unit))

    tabulate = partial(with_theory, unit=unit)
    draw = partial(
        two_pressures,
        x="eps_f",
        y=f"gap_over_{unit}",
        theory=gap_theory(unit, eps_f_range),
        base=10 if eps_f_range else 2,
        logarithmic=True,
    )
    return Study(name, tabulate, draw, decades_needed if eps_f_range else compare)


STUDIES = (
    Study("fig4", means, partial(two_pressures, x="eps_c", y=GAP), coarse_grid),
    Study("fig5", means, partial(two_pressures, x="eps_t", y=GAP), finite_size),
    _against_theory("fig6", "h_rms"),
    _against_theory("fig7", "g_rms_lam_s"),
    _against_theory("fig8", "g_rms_lam_s", FIG8_EPS_F),
)
