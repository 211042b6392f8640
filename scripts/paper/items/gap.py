"""Figures 4 to 8: the mean gap against eps_c, eps_t and eps_f at the two pressures of the paper."""

from collections.abc import Iterator
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from hpc_gfmd.theory import persson

from .. import printed
from ..estimates import average, power_law
from ..pictures import gap_lines, two_pressures
from ..printed import NUMBERS, of_hurst
from ..rows import (
    PRESSURES,
    Rows,
    by_hurst,
    coarsest,
    families,
    fine_half,
    finest,
    longest,
    low_high,
    near,
    quoted,
    saying,
)
from ..study import Study

GAP = "gap_over_h_rms"
WIDEST = (1e-16, 0.5)  # of eps_f in figure 8
CONVERGED = 0.1  # this near the fractal limit counts as converged
THEORIES = (("persson", False), ("persson_printed", True))


def means(runs: Rows, level: str) -> Rows:
    """Average gap/h_rms over realisations."""
    return average(runs, GAP)


def with_theory(runs: Rows, level: str = "", unit: str = "h_rms") -> Rows:
    """Average the gap in a unit; add Persson's, corrected and printed, and simulation over it."""
    rows = average(runs, f"gap_over_{unit}")
    for row in rows:
        at = (row["p_star"], row["hurst"], row["eps_f"])
        for name, as_printed in THEORIES:
            gap = row[name] = float(persson.mean_gap(*at, printed=as_printed, unit=unit))
            row[f"over_{name}"] = row[f"gap_over_{unit}"] / gap if gap > 0 else None
    return rows


def share_explained(rows: Rows) -> float | None:
    """Compute how much of ln(simulation/theory) the missing factor of 2 accounts for, mean over the
    finer half of the rows; None of no rows."""
    ratios = [[row["over_persson"], row["over_persson_printed"]] for row in fine_half(rows)]
    logs = [np.log(b / a) / np.log(b) for a, b in ratios if a and b]
    return float(np.mean(logs)) if logs else None


def coarse_grid(rows: Rows) -> Iterator[dict]:
    """Compare how much a coarse grid changes the gap at the high pressure."""
    for hurst, chosen in by_hurst(low_high(rows)["high"]).items():
        ratio, series = of_hurst("gap_ratio_eps_c", hurst), longest(chosen, "eps_c")
        if ratio and len(series) > 1:
            best = finest(series, "eps_c")
            yield saying(
                f"{printed.at('high', hurst)}: gap {ratio:g} times the limit at eps_c = 1/2",
                "{ratio:.4f} times that at eps_c = {eps_c:1/} (lam_l/lam_s = {lam_l_over_lam_s:g})",
                "the same surfaces on finer grids: this is what the grid alone does",
                **best,
                ratio=coarsest(series, "eps_c")[GAP] / best[GAP],
            )


def finite_size(rows: Rows) -> Iterator[dict]:
    """Compare the sign and size of the finite-size correction."""
    for pressure, hurst, chosen in families(rows):
        row, series = printed.coefficients(GAP, pressure, hurst), longest(chosen, "eps_t")
        if row and len(series) > 1:
            small, large = coarsest(series, "eps_t"), finest(series, "eps_t")
            slope = (small[GAP] - large[GAP]) / (small["eps_t"] - large["eps_t"])
            yield saying(
                f"{printed.at(pressure, hurst)}: C_t = {row['C_t']:g}",
                f"{slope:+.3g} from eps_t = {small['eps_t']:g} to {large['eps_t']:g} (lam_l/lam_s ="
                " {lam_l_over_lam_s:g})",
                "the few longest waves make h_rms, and scatter most",
                **small,
            )


def exponents(rows: Rows, unit: str) -> Iterator[dict]:
    """Compare the exponents of eps_f; in the unit g_rms lam_s, those in the unit h_rms less H are
    expected."""
    for pressure, hurst, chosen in families(rows):
        alpha, sigma = power_law(fine_half(chosen), "eps_f", f"gap_over_{unit}")
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
        yield saying(
            f"{printed.at(pressure, hurst)}: exponent of eps_f {claim:g}", quoted(alpha, sigma), why
        )


def theory_factors(rows: Rows, unit: str) -> Iterator[dict]:
    """Compare by how much Persson's theory is too small at the high pressure."""
    for hurst, part in by_hurst(low_high(rows)["high"]).items():
        if (explained := share_explained(part)) is not None:
            as_printed, corrected = (
                span([row[f"over_{name}"] for row in fine_half(part) if row[f"over_{name}"]])
                for name in ("persson_printed", "persson")
            )
            yield saying(
                f"{printed.at('high', hurst)}: theory {of_hurst(f'theory_factor_{unit}', hurst):g}"
                " times too small",
                f"{as_printed} times as printed, {corrected} times corrected",
                f"the missing factor 2 explains {explained:.0%} of the logarithm of our ratio",
            )


def decades_needed(rows: Rows) -> Iterator[dict]:
    """Compare how many decades of roughness the fractal limit needs at the low pressure."""
    claim = NUMBERS["decades_to_fractal_limit"]
    if not any(near(row["hurst"], claim["hurst"]) for row in low_high(rows)["low"]):
        return

    def gap(decades):
        at = (PRESSURES["low"], claim["hurst"], 10.0**-decades)
        return float(persson.mean_gap(*at, unit="g_rms_lam_s")) / float(
            persson.mean_gap(*at[:2], 1e-60, unit="g_rms_lam_s")
        )

    needed = next(d for d in np.arange(1, 41) / 2 if gap(d) >= 1 - CONVERGED)
    yield saying(
        f"H = {claim['hurst']:g}, a_r of order 0.01: self-affine over {claim['decades']} decades"
        " until the gap has its fractal limit",
        f"corrected theory: within {CONVERGED:.0%} after {needed:g} decades; after three it has"
        f" {gap(3):.1g} of it",
        "no simulation can show the limit; theory that fits the data at large eps_f says where it"
        " lies",
    )


def span(values: list[Any], digits: int = 2) -> str:
    """Write the range of values, "1.08 to 1.10"."""
    low, high = f"{min(values):.{digits}f}", f"{max(values):.{digits}f}"
    return low if low == high else f"{low} to {high}"


def _against_theory(name, unit, widest=()):
    """Make the study of the gap in a unit against eps_f, with theory over `widest` or the data."""
    how: dict[str, Any] = {"x": "eps_f", "y": f"gap_over_{unit}", "logarithmic": True}
    how |= {"theory": gap_lines(unit, widest), "base": 10 if widest else 2}

    def compare(rows):
        return chain(exponents(rows, unit), theory_factors(rows, unit))

    tabulate, draw = partial(with_theory, unit=unit), partial(two_pressures, **how)
    return Study(name, tabulate, draw, decades_needed if widest else compare)


STUDIES = (
    Study("fig4", means, partial(two_pressures, x="eps_c", y=GAP), coarse_grid),
    Study("fig5", means, partial(two_pressures, x="eps_t", y=GAP), finite_size),
    _against_theory("fig6", "h_rms"),
    _against_theory("fig7", "g_rms_lam_s"),
    _against_theory("fig8", "g_rms_lam_s", WIDEST),
)
