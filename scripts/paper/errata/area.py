"""Errata of the paper's statements about the contact area, shown with the rows of our items."""

from typing import Any

from ..items import kappa
from ..printed import NUMBERS, coefficients, correction, of_hurst
from ..rows import (
    PRESSURES,
    Rows,
    by_hurst,
    coarsest,
    filled,
    filled_with_each,
    finest,
    longest,
    low_high,
    near,
    where,
)

SLOPE = NUMBERS["slope"]


def area_is_half_kappa(tables: dict[str, Rows]) -> Any:
    high = by_hurst(low_high(tables["fig1"])["high"])
    best = [finest(rows, "eps_c") for h, rows in high.items() if of_hurst("area_high", h)]
    if len(best) < len(NUMBERS["area_high"]):
        return ""
    areas = [
        row | {"a_r": row["kappa_edge"] * PRESSURES["high"], "half": row["kappa_edge"] / 2}
        for row in best
    ]
    ours = filled_with_each("a_r = {a_r:.3f}, kappa/2 = {half:.3f} at H = {hurst:g}", areas)
    return f"edge-corrected on the finest grid: {ours}"


def exponent_of_the_grid(tables: dict[str, Rows]) -> Any:
    rows = [row for row in tables["fig1"] if row.get("kappa_alpha") is not None]
    finest_rows = {
        (row["hurst"], row["p_star"]): row for row in sorted(rows, key=lambda row: -row["eps_c"])
    }
    template = "{kappa_alpha:±} (H = {hurst:g}, p* = {p_star:.3f}, around eps_c = {eps_c:1/})"
    ordered = [finest_rows[key] for key in sorted(finest_rows)]
    return ordered and f"finest local exponents: {filled_with_each(template, ordered)}"


def terms_do_not_add(tables: dict[str, Rows]) -> Any:
    steps_of_hurst = []
    fractal = []
    for hurst, rows in by_hurst(low_high(tables["fig1"])["low"]).items():
        coarse, fine = (
            {row["lam_l_over_lam_s"]: row["kappa"] for row in rows if near(row["eps_c"], eps_c)}
            for eps_c in (0.5, 0.25)
        )
        shared = sorted(coarse.keys() & fine.keys())
        steps = [f"{coarse[f] - fine[f]:.3f} at eps_f = 1/{f:g}" for f in shared]
        if len(steps) > 1:
            steps_of_hurst.append(f"H = {hurst:g}: {', '.join(steps)}")
    for hurst, rows in by_hurst(low_high(tables["fig2"])["low"]).items():
        raw, edge = (
            coarsest(rows, "eps_f")[name] - finest(rows, "eps_f")[name]
            for name in kappa.OBSERVABLES
        )
        if raw:
            fractal.append(f"{raw:.2f} and {edge:.2f} (H = {hurst:g})")
    return steps_of_hurst and (
        f"kappa(eps_c = 1/2) - kappa(1/4): {'; '.join(steps_of_hurst)}. Fall of kappa along the"
        f" eps_f series at eps_c = 1/2, as counted and edge-corrected: {', '.join(fractal)}"
    )


def fractal_error(tables: dict[str, Rows]) -> Any:
    return kappa.fractal_excess(tables["fig2"])


def six_percent(_tables: object) -> str:
    parts = []
    for claim in NUMBERS["reference_error"]:
        total = correction(coefficients("kappa", "low", claim["hurst"]), claim)
        limit = of_hurst("kappa_tfc", claim["hurst"]) or SLOPE["high"]
        n = 1 / (claim["eps_c"] * claim["eps_f"] * claim["eps_t"])
        system = filled("H = {hurst:g}, eps_c = {eps_c:1/}, eps_f = {eps_f:1/}", claim)
        parts.append(f"{system} (n = {n:.0f}): {total:.3f}, {total / limit:.0%} of {limit:g}")
    return "; ".join(parts)


def grid_needed(tables: dict[str, Rows]) -> Any:
    hurst = NUMBERS["eps_c_needed"]["hurst"]
    ours = []
    terms = []
    for name, table in (("kappa", "fig1"), ("kappa_edge", "fig1"), ("gap_over_h_rms", "fig4")):
        low = [row for row in low_high(tables[table])["low"] if near(row["hurst"], hurst)]
        rows = longest(low, "eps_c")
        if len(rows) < 2:
            return ""
        coarse = coarsest(rows, "eps_c")
        fine = finest(rows, "eps_c")
        ours.append(coarse[name] / fine[name] - 1)
        if row := coefficients(name, "low", hurst):
            total = of_hurst("kappa_tfc", hurst) if name == "kappa" else coarse[name]
            terms.append(row["C_c"] * 0.5 ** row["alpha_c"] / total)
    return (
        "continuum terms at eps_c = 1/2 by the paper's tables: {:.1%} of kappa, {:.1%} of the gap;"
        " ours, against the finest grid: kappa {:+.1%} as counted, {:+.1%} edge-corrected, gap"
        " {:+.2%}".format(*terms, *ours)
    )


def spread_over_hurst(tables: dict[str, Rows]) -> Any:
    low = low_high(where(tables["table5"], area="ours"))["low"]
    ours = filled_with_each("{kappa_tfc:±} (H = {hurst:g})", low)
    text = (
        f"{SLOPE['high']:g} and {SLOPE['low']:g} differ by {SLOPE['high'] / SLOPE['low'] - 1:.1%}"
    )
    return text + (f"; ours in the limit: {ours}" if ours else "")
