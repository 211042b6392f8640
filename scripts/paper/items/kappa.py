"""Figures 1 to 3: kappa against eps_c, eps_f and eps_t at the two pressures of the paper."""

from collections.abc import Callable
from functools import partial

from .. import fits, paper
from ..averages import average, relative_scatter
from ..catalogue import Study
from ..draw import kappa_lines, two_pressures
from ..levels import eps_c_series, eps_f_series, eps_t_series
from ..paper import Sayings, of_hurst, saying
from ..rows import (
    Rows,
    by_hurst,
    coarsest,
    families,
    finest,
    groups,
    longest,
    low_high,
    near,
    where,
)
from ..text import filled

OBSERVABLES = ("kappa", "kappa_edge")  # as counted, edge-corrected


def means(runs: Rows, level: str) -> Rows:
    """Means over realisations."""
    return average(runs, OBSERVABLES)


def means_and_exponents(runs: Rows, level: str) -> Rows:
    """The means; where the series is long enough, alpha_c between neighbouring octaves of paired
    differences (NAME_alpha, NAME_alpha_se)."""
    rows = average(runs, OBSERVABLES)
    for (hurst, p_star), part in groups(runs, "hurst", "p_star").items():
        fine = longest(where(rows, hurst=hurst, p_star=p_star), "eps_c")
        for observable in OBSERVABLES:
            for local in fits.local_exponents(part, observable, level):
                (row,) = where(fine, eps_c=local["eps_c"])
                row |= {
                    f"{observable}_alpha": local["alpha"],
                    f"{observable}_alpha_se": local["alpha_se"],
                }
    return rows


def exponent_and_area(rows: Rows) -> Sayings:
    """The exponent alpha_c, and the contact area that the text gives."""
    for pressure, hurst, chosen in families(rows):
        known = [row for row in longest(chosen, "eps_c") if row.get("kappa_alpha") is not None]
        if known:
            yield saying(
                f"{paper.at(pressure, hurst)}: alpha_c = {paper.numbers()['alpha_c']:g}",
                filled("{kappa_alpha:±} around eps_c = {eps_c:1/}, ", coarsest(known, "eps_c"))
                + filled("{kappa_alpha:±} around {eps_c:1/}", finest(known, "eps_c")),
                "a contact boundary of finite length makes the excess of counted points linear in"
                " eps_c for eps_c -> 0",
            )
    printed = paper.numbers()["area_high"]
    for hurst, chosen in by_hurst(low_high(rows)["high"]).items():
        if ours := of_hurst("area_high", hurst):
            other = next(a_r for name, a_r in printed.items() if name != f"{hurst:g}")
            best = finest(chosen, "eps_c")
            p_star = best["p_star"]
            yield saying(
                f"a_r = {ours:g} at {paper.at('high', hurst)}",
                f"a_r = {best['kappa'] * p_star:.3f} as counted, {best['kappa_edge'] * p_star:.3f}"
                " edge-corrected, on the finest grid",
                f"printed is kappa/2, which is a_r = {2 * ours * p_star:.3f}; the number printed"
                f" for the other H is a_r = {2 * other * p_star:.3f}",
            )


def fractal_claim() -> tuple[str, str]:
    """What the text says of the fractal error of kappa, and what its formula and its table make of
    it."""
    claim = paper.numbers()["fractal_error"]
    printed = paper.coefficients("kappa", "low", claim["hurst"])
    by_table = (
        printed["C_f"]
        * claim["eps_f"] ** printed["alpha_f"]
        / of_hurst("kappa_tfc", claim["hurst"])
    )
    by_text = claim["coefficient"] * claim["eps_f"] ** paper.numbers()["alpha_f"]
    return (
        (
            f"H = 0.8, lam_l/lam_s = {1 / claim['eps_f']:g}: kappa {claim['error']:.0%} too large,"
            f" from {claim['coefficient']:g} eps_f^0.67"
        ),
        (
            f"{claim['coefficient']:g} eps_f^0.67 is {by_text:.2f} in kappa, not"
            f" {claim['error']:.0%} of it; the table's C_f = {printed['C_f']:g} makes it"
            f" {by_table:.0%}; counting grid points at eps_c = 1/2 enlarges the fractal correction"
        ),
    )


def fractal_excess(rows: Rows) -> str:
    """What we find of it; "" of rows that do not reach that far."""
    claim = paper.numbers()["fractal_error"]
    chosen = [row for row in low_high(rows)["low"] if near(row["hurst"], claim["hurst"])]
    at = next((row for row in chosen if near(row["eps_f"], claim["eps_f"])), None)
    best = finest(chosen, "eps_f")
    if at is None or best is at:
        return ""
    raw, edge = (at[name] / best[name] - 1 for name in OBSERVABLES)
    return (
        f"{raw:.0%} above lam_l/lam_s = {1 / best['eps_f']:g} as counted, {edge:.0%} edge-corrected"
    )


def fractal_error(rows: Rows) -> Sayings:
    """The fractal error that the text gives for H = 0.8."""
    claim, why = fractal_claim()
    if found := fractal_excess(rows):
        yield saying(claim, found, why)


def finite_size(rows: Rows) -> Sayings:
    """The scatter that the text gives, and the trend with eps_t."""
    for pressure, part in low_high(rows).items():
        fine = [row for row in part if row["eps_f"] == min(row["eps_f"] for row in part)]
        known = {
            row["hurst"]: x
            for row in fine
            if row["eps_t"] == 0.5 and (x := relative_scatter(row, "kappa"))
        }
        drift = {
            h: coarsest(r, "eps_t")["kappa"] / finest(r, "eps_t")["kappa"] - 1
            for h, r in by_hurst(fine).items()
            if len(r) > 1
        }
        if known and drift:
            yield saying(
                f"p* = {paper.PRINTED[pressure]}: kappa fluctuates by"
                f" {paper.numbers()['kappa_fluctuation'][pressure]:.1%}",
                "one realisation, eps_t = 1/2: "
                + ", ".join(f"{x:.2%} (H = {h:g})" for h, x in known.items()),
                "scatter grows with H and falls as eps_t; from the smallest cell to the largest"
                " kappa changes by " + ", ".join(f"{x:+.1%} (H = {h:g})" for h, x in drift.items()),
            )


def _drawn(ratio: str, series: str = "lam_l_over_lam_s") -> Callable:
    return partial(two_pressures, x=ratio, observable="kappa", series=series, theory=kappa_lines)


STUDIES = (
    Study(
        "fig1",
        "kappa against eps_c",
        "kappa falls as eps_c^0.67 to about 2 at p* = 0.007, and below 2 at 0.353; eps_t = 1/2,"
        " eps_f = 1/1024",
        eps_c_series,
        means_and_exponents,
        _drawn("eps_c"),
        exponent_and_area,
    ),
    Study(
        "fig2",
        "kappa against eps_f",
        "kappa falls as eps_f^0.67, by up to 30 % for H = 0.8 at p* = 0.007, hardly at 0.353; eps_t"
        " = eps_c = 1/2",
        eps_f_series,
        means,
        _drawn("eps_f", "lam_s_over_a"),
        fractal_error,
    ),
    Study(
        "fig3",
        "kappa against eps_t",
        "kappa nearly independent of eps_t: 1 % at p* = 0.007, 0.1 % at 0.353; eps_f = 1/1024,"
        " eps_c = 1/2",
        eps_t_series,
        means,
        _drawn("eps_t"),
        finite_size,
    ),
)
