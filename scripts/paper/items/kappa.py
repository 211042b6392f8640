"""Figures 1 to 3: kappa against eps_c, eps_f and eps_t at the two pressures of the paper."""

from collections.abc import Iterator
from functools import partial

from .. import printed
from ..estimates import average, local_exponents
from ..pictures import draw_kappa_theory, two_pressures
from ..printed import NUMBERS
from ..rows import (
    Rows,
    by_hurst,
    coarsest,
    comparison,
    families,
    filled,
    filled_with_each,
    finest,
    groups,
    longest,
    low_high,
    near,
    where,
)
from ..study import Study

OBSERVABLES = ("kappa", "kappa_edge")  # as counted, edge-corrected


def means(runs: Rows, level: str) -> Rows:
    """Average over realisations."""
    return average(runs, *OBSERVABLES)


def means_and_exponents(runs: Rows, level: str) -> Rows:
    """Average over realisations and add alpha_c between neighbouring octaves of long series.

    Its columns are NAME_alpha and NAME_alpha_se (estimates.local_exponents).
    """
    rows = means(runs, level)
    for (hurst, p_star), part in groups(runs, "hurst", "p_star").items():
        fine = longest(where(rows, hurst=hurst, p_star=p_star), "eps_c")
        for name in OBSERVABLES:
            for local in local_exponents(part, name, level):
                (row,) = where(fine, eps_c=local["eps_c"])
                row |= {f"{name}_{key}": local[key] for key in ("alpha", "alpha_se")}
    return rows


def exponents(rows: Rows) -> Iterator[dict]:
    """Compare the exponent alpha_c."""
    for pressure, hurst, family in families(rows):
        series = [row for row in longest(family, "eps_c") if row.get("kappa_alpha") is not None]
        if series:
            ends = [coarsest(series, "eps_c"), finest(series, "eps_c")]
            yield comparison(
                f"{printed.family_label(pressure, hurst)}: alpha_c = {NUMBERS['alpha_c']:g}",
                filled_with_each("{kappa_alpha:±} around eps_c = {eps_c:1/}", ends),
            )


def fractal_excess(rows: Rows) -> str:
    """Return our fractal error in words; "" if the series does not extend beyond the paper's."""
    claim = NUMBERS["fractal_error"]
    series = [row for row in low_high(rows)["low"] if near(row["hurst"], claim["hurst"])]
    claimed = next((row for row in series if near(row["eps_f"], claim["eps_f"])), None)
    best = finest(series, "eps_f")
    if claimed is None or best is claimed:
        return ""
    raw, edge = (claimed[name] / best[name] - 1 for name in OBSERVABLES)
    return filled(
        f"{raw:.0%} above lam_l/lam_s = {{lam_l_over_lam_s:g}} as counted, {edge:.0%}"
        " edge-corrected",
        best,
    )


def fractal_error(rows: Rows) -> Iterator[dict]:
    """Compare the fractal error that the text gives for H = 0.8."""
    if ours := fractal_excess(rows):
        yield comparison("H = 0.8, lam_l/lam_s = 32: kappa 30% too large, from 3 eps_f^0.67", ours)


def finite_size(rows: Rows) -> Iterator[dict]:
    """Compare the scatter of realisations that the text gives, and report the trend with eps_t."""
    for pressure, part in low_high(rows).items():
        smallest_eps_f = min((row["eps_f"] for row in part), default=0)
        scatter = []
        drift = []
        for hurst, series in by_hurst(where(part, eps_f=smallest_eps_f)).items():
            for row in where(series, eps_t=0.5):
                if row["kappa_se"]:
                    relative = row["kappa_se"] * row["n_seeds"] ** 0.5 / row["kappa"]
                    scatter.append(f"{relative:.2%} (H = {hurst:g})")
            if len(series) > 1:
                change = coarsest(series, "eps_t")["kappa"] / finest(series, "eps_t")["kappa"] - 1
                drift.append(f"{change:+.1%} (H = {hurst:g})")
        if scatter and drift:
            yield comparison(
                f"p* = {printed.PRINTED[pressure]}: kappa fluctuates by"
                f" {NUMBERS['kappa_fluctuation'][pressure]:.1%}",
                f"one realisation, eps_t = 1/2: {', '.join(scatter)}",
                "from the smallest cell to the largest kappa changes by " + ", ".join(drift),
            )


_draw = partial(two_pressures, y="kappa", theory=draw_kappa_theory)
STUDIES = (
    Study("fig1", means_and_exponents, partial(_draw, x="eps_c"), exponents),
    Study("fig2", means, partial(_draw, x="eps_f"), fractal_error),
    Study("fig3", means, partial(_draw, x="eps_t"), finite_size),
)
