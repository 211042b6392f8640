"""Figures 4 to 8: the mean gap against eps_c, eps_t and eps_f at the two pressures of the paper."""

from collections.abc import Callable
from functools import partial
from itertools import chain

import numpy as np

from hpc_gfmd.theory import persson

from .. import fits, paper
from ..averages import average, relative_scatter
from ..catalogue import Study
from ..draw import gap_lines, two_pressures
from ..levels import P_LOW, eps_c_series, eps_f_series, eps_t_series
from ..paper import Sayings, of_hurst, saying
from ..rows import Rows, by_hurst, coarsest, families, fine_half, finest, longest, low_high, near
from ..text import quoted

GAP = "gap_over_h_rms"
WIDEST = (1e-16, 0.5)  # of eps_f in figure 8
CONVERGED = 0.1  # this near the fractal limit counts as converged


def means(runs: Rows, level: str) -> Rows:
    """Means over realisations of gap/h_rms."""
    return average(runs, (GAP,))


def with_theory(runs: Rows, level: str | None = None, unit: str = "h_rms") -> Rows:
    """Means over realisations of the gap in a unit with Persson's, corrected and as printed, and
    the ratios of simulation to both."""
    rows = average(runs, (f"gap_over_{unit}",))
    for row in rows:
        theory = {
            name: float(
                persson.mean_gap(
                    row["p_star"], row["hurst"], row["eps_f"], printed=printed, unit=unit
                )
            )
            for name, printed in (("persson", False), ("persson_printed", True))
        }
        row |= theory | {
            f"over_{name}": row[f"gap_over_{unit}"] / gap if gap > 0 else None
            for name, gap in theory.items()
        }
    return rows


def share_explained(rows: Rows) -> float | None:
    """How much of ln(simulation/theory) the missing factor of 2 accounts for, mean over the finer
    half of the rows; None of no rows."""
    part = [row for row in fine_half(rows) if row["over_persson"] and row["over_persson_printed"]]
    logs = [
        np.log(row["over_persson_printed"] / row["over_persson"])
        / np.log(row["over_persson_printed"])
        for row in part
    ]
    return float(np.mean(logs)) if logs else None


def coarse_grid(rows: Rows) -> Sayings:
    """How much a coarse grid changes the gap at the high pressure."""
    for hurst, chosen in by_hurst(low_high(rows)["high"]).items():
        printed, series = of_hurst("gap_ratio_eps_c", hurst), longest(chosen, "eps_c")
        if printed and len(series) > 1:
            best = finest(series, "eps_c")
            yield saying(
                f"{paper.at('high', hurst)}: gap {'almost' if printed > 2 else 'roughly'}"
                f" {printed:g} times the limit at eps_c = 1/2",
                "{ratio:.4f} times that at eps_c = {eps_c:1/} (lam_l/lam_s = {lam_l_over_lam_s:g})",
                "the same surfaces on finer grids, the error of every gap bounded by its duality"
                " gap: this is what the grid alone does",
                **best,
                ratio=coarsest(series, "eps_c")[GAP] / best[GAP],
            )


def finite_size(rows: Rows) -> Sayings:
    """The sign and size of the finite-size correction."""
    for pressure, hurst, chosen in families(rows):
        printed, series = paper.coefficients(GAP, pressure, hurst), longest(chosen, "eps_t")
        if printed and len(series) > 1:
            small, large = coarsest(series, "eps_t"), finest(series, "eps_t")
            slope = (small[GAP] - large[GAP]) / (small["eps_t"] - large["eps_t"])
            yield saying(
                f"{paper.at(pressure, hurst)}: C_t = {printed['C_t']:g}",
                f"{slope:+.3g} from eps_t = {small['eps_t']:g} to {large['eps_t']:g} (lam_l/lam_s ="
                f" {small['lam_l_over_lam_s']:g})",
                f"one realisation scatters by {relative_scatter(small, GAP) or 0:.1%} at eps_t ="
                f" {small['eps_t']:g}: the few longest waves make h_rms; both cutoffs are included"
                " here, and how they are cut matters at eps_t = 1",
            )


def exponents(rows: Rows, unit: str) -> Sayings:
    """The exponents of eps_f beside those of the paper. In the unit g_rms lam_s, those in the unit
    h_rms less H are expected."""
    for pressure, hurst, chosen in families(rows):
        alpha, sigma = fits.power_law(fine_half(chosen), "eps_f", f"gap_over_{unit}")
        printed = of_hurst(f"gap_exponents_{unit}", hurst, pressure)
        if alpha is None or printed is None:
            continue
        why = "ours: the finer half of the octaves; the exponent still changes with eps_f"
        if unit == "g_rms_lam_s":
            expected = of_hurst("gap_exponents_h_rms", hurst, pressure) - hurst
            why = (
                "exponents in the two units differ by H, so the paper's own in units of h_rms"
                f" makes this one {expected:+.3f}; negative: the gap in units of g_rms lam_s rises"
                " as eps_f falls"
            )
        yield saying(
            f"{paper.at(pressure, hurst)}: exponent of eps_f {printed:g}", quoted(alpha, sigma), why
        )


def theory_factors(rows: Rows, unit: str) -> Sayings:
    """By how much Persson's theory is too small at the high pressure: as printed, corrected, and
    what the missing factor explains."""
    for hurst, part in by_hurst(low_high(rows)["high"]).items():
        if (explained := share_explained(part)) is not None:
            spans = [
                _span([row[name] for row in fine_half(part) if row[name]])
                for name in ("over_persson_printed", "over_persson")
            ]
            printed = of_hurst(f"theory_factor_{unit}", hurst) or 0
            yield saying(
                f"{paper.at('high', hurst)}: theory {printed:g} times too small",
                f"{spans[0]} times as printed, {spans[1]} times corrected",
                f"the missing factor 2 in the second term explains {explained:.0%} of the logarithm"
                " of our ratio",
            )


def decades_needed(rows: Rows) -> Sayings:
    """How many decades of roughness the fractal limit needs for H = 0.8 at the low pressure."""
    claim = paper.numbers()["decades_to_fractal_limit"]
    if not any(near(row["hurst"], claim["hurst"]) for row in low_high(rows)["low"]):
        return

    def gap(eps_f: float) -> float:
        return float(persson.mean_gap(P_LOW, claim["hurst"], eps_f, unit="g_rms_lam_s"))

    limit = gap(1e-60)
    needed = next(d for d in np.arange(1, 41) / 2 if gap(10.0**-d) >= (1 - CONVERGED) * limit)
    yield saying(
        f"H = {claim['hurst']:g}, a_r of order 0.01: self-affine over {claim['decades']} decades"
        " before the gap has its fractal limit",
        f"corrected theory: within {CONVERGED:.0%} after {needed:g} decades; after three it has"
        f" {gap(1e-3) / limit:.1g} of it",
        "no simulation can show the limit; theory that fits the data at large eps_f says where it"
        " lies",
    )


def _span(values: list) -> str:
    low, high = f"{min(values):.2f}", f"{max(values):.2f}"
    return low if low == high else f"{low} to {high}"


def _against_ratio(
    name: str,
    ratio: str,
    paper_says: str,
    series: Callable[[str], list],
    compare: Callable[[Rows], Sayings],
) -> Study:
    """gap/h_rms against a ratio; marks tell eps_f."""
    draw = partial(two_pressures, x=ratio, observable=GAP)
    return Study(name, f"gap/h_rms against {ratio}", paper_says, series, means, draw, compare)


def _against_theory(
    name: str,
    title: str,
    unit: str,
    paper_says: str,
    compare: Callable[[Rows], Sayings],
    widest: tuple[float, float] | None = None,
) -> Study:
    """The gap in a unit against eps_f, with Persson's theory over the range of the data or over
    `widest`."""
    draw = partial(
        two_pressures,
        x="eps_f",
        observable=f"gap_over_{unit}",
        series="lam_s_over_a",
        theory=gap_lines(unit, widest),
        base=10 if widest else 2,
    )
    return Study(
        name, title, paper_says, eps_f_series, partial(with_theory, unit=unit), draw, compare
    )


def _exponents_and_factors(unit: str) -> Callable[[Rows], Sayings]:
    return lambda rows: chain(exponents(rows, unit), theory_factors(rows, unit))


STUDIES = (
    _against_ratio(
        "fig4",
        "eps_c",
        "linear in eps_c; three times the limit at eps_c = 1/2 for H = 0, p* = 0.353, 20 % above it"
        " for H = 0.8",
        eps_c_series,
        coarse_grid,
    ),
    _against_ratio(
        "fig5",
        "eps_t",
        "linear in eps_t, scatter large at low p* and large H; eps_f = 1/1024, eps_c = 1/2",
        eps_t_series,
        finite_size,
    ),
    _against_theory(
        "fig6",
        "gap/h_rms against eps_f, with Persson theory",
        "h_rms",
        "power laws; theory within 10 % at p* = 0.007, 2 to 3 times too small at 0.353",
        _exponents_and_factors("h_rms"),
    ),
    _against_theory(
        "fig7",
        "gap/(g_rms lam_s) against eps_f, with Persson theory",
        "g_rms_lam_s",
        "theory scaled by 3.3, 3.1, 2.75, 2 (H = 0, 0.3, 0.5, 0.8) at p* = 0.353 and not at 0.007",
        _exponents_and_factors("g_rms_lam_s"),
    ),
    _against_theory(
        "fig8",
        "gap/(g_rms lam_s) against eps_f over 15 decades",
        "g_rms_lam_s",
        "Persson theory converges in the fractal limit, far below any eps_f that can be solved",
        decades_needed,
        WIDEST,
    ),
)
