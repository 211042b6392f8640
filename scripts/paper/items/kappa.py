"""Figures 1 to 3: kappa against eps_c, eps_f and eps_t at the two pressures of the paper."""

from collections.abc import Iterator
from functools import partial

from .. import printed
from ..estimates import average, local_exponents
from ..pictures import kappa_lines, two_pressures
from ..printed import NUMBERS
from ..rows import (
    Rows,
    by_hurst,
    coarsest,
    each,
    families,
    filled,
    finest,
    groups,
    longest,
    low_high,
    near,
    saying,
    where,
)
from ..study import Study

OBSERVABLES = ("kappa", "kappa_edge")  # as counted, edge-corrected


def means(runs: Rows, level: str) -> Rows:
    """Average over realisations."""
    return average(runs, *OBSERVABLES)


def means_and_exponents(runs: Rows, level: str) -> Rows:
    """Average; where the series is long enough, find alpha_c between neighbouring octaves
    (NAME_alpha, NAME_alpha_se)."""
    rows = means(runs, level)
    for (hurst, p_star), part in groups(runs, "hurst", "p_star").items():
        fine = longest(where(rows, hurst=hurst, p_star=p_star), "eps_c")
        for name in OBSERVABLES:
            for local in local_exponents(part, name, level):
                (row,) = where(fine, eps_c=local["eps_c"])
                row |= {f"{name}_{what}": local[what] for what in ("alpha", "alpha_se")}
    return rows


def exponents(rows: Rows) -> Iterator[dict]:
    """Compare the exponent alpha_c."""
    for pressure, hurst, chosen in families(rows):
        known = [row for row in longest(chosen, "eps_c") if row.get("kappa_alpha") is not None]
        if known:
            ends = [coarsest(known, "eps_c"), finest(known, "eps_c")]
            yield saying(
                f"{printed.at(pressure, hurst)}: alpha_c = {NUMBERS['alpha_c']:g}",
                each("{kappa_alpha:±} around eps_c = {eps_c:1/}", ends),
            )


def fractal_excess(rows: Rows) -> str:
    """Say what we find of it; "" of rows that do not reach that far."""
    claim = NUMBERS["fractal_error"]
    chosen = [row for row in low_high(rows)["low"] if near(row["hurst"], claim["hurst"])]
    at = next((row for row in chosen if near(row["eps_f"], claim["eps_f"])), None)
    best = finest(chosen, "eps_f")
    if at is None or best is at:
        return ""
    raw, edge = (at[name] / best[name] - 1 for name in OBSERVABLES)
    return filled(
        f"{raw:.0%} above lam_l/lam_s = {{lam_l_over_lam_s:g}} as counted, {edge:.0%}"
        " edge-corrected",
        best,
    )


def fractal_error(rows: Rows) -> Iterator[dict]:
    """Compare the fractal error that the text gives for H = 0.8."""
    if found := fractal_excess(rows):
        yield saying("H = 0.8, lam_l/lam_s = 32: kappa 30% too large, from 3 eps_f^0.67", found)


def finite_size(rows: Rows) -> Iterator[dict]:
    """Compare the scatter that the text gives, and the trend with eps_t."""
    for pressure, part in low_high(rows).items():
        scatter, drift = [], []
        for hurst, series in by_hurst(
            where(part, eps_f=min((r["eps_f"] for r in part), default=0))
        ).items():
            for row in where(series, eps_t=0.5):
                if row["kappa_se"]:
                    one = row["kappa_se"] * row["n_seeds"] ** 0.5 / row["kappa"]
                    scatter.append(f"{one:.2%} (H = {hurst:g})")
            change = coarsest(series, "eps_t")["kappa"] / finest(series, "eps_t")["kappa"] - 1
            drift += [f"{change:+.1%} (H = {hurst:g})"] if len(series) > 1 else []
        if scatter and drift:
            yield saying(
                f"p* = {printed.PRINTED[pressure]}: kappa fluctuates by"
                f" {NUMBERS['kappa_fluctuation'][pressure]:.1%}",
                f"one realisation, eps_t = 1/2: {', '.join(scatter)}",
                "from the smallest cell to the largest kappa changes by " + ", ".join(drift),
            )


_drawn = partial(partial, two_pressures, y="kappa", theory=kappa_lines)
STUDIES = (
    Study("fig1", means_and_exponents, _drawn(x="eps_c"), exponents),
    Study("fig2", means, _drawn(x="eps_f"), fractal_error),
    Study("fig3", means, _drawn(x="eps_t"), finite_size),
)
