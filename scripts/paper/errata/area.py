"""Errata of what the paper says about the contact area, each shown by the rows of our figures and
tables."""

from typing import Any

from .. import paper
from ..items import kappa
from ..levels import P_HIGH
from ..paper import of_hurst
from ..rows import Rows, by_hurst, coarsest, finest, longest, low_high, near, where
from ..text import filled
from . import Errata

ERRATA = Errata()
SLOPE = paper.numbers()["slope"]


@ERRATA.add(
    "a_r from 0.837 for H = 0.8 to 0.802 for H = 0 at p* = 0.353",
    "these are kappa/2, and the two H are exchanged",
)
def area_is_half_kappa(tables: dict[str, Rows]) -> Any:
    found = {
        h: finest(rows, "eps_c")["kappa_edge"]
        for h, rows in by_hurst(low_high(tables["fig1"])["high"]).items()
        if of_hurst("area_high", h)
    }
    if len(found) < len(paper.numbers()["area_high"]):
        return ""
    ours = ", ".join(
        f"a_r = {k * P_HIGH:.3f}, kappa/2 = {k / 2:.3f} at H = {h:g}" for h, k in found.items()
    )
    order = "rises" if found[min(found)] > found[max(found)] else "falls"
    return (
        f"edge-corrected on the finest grid: {ours}; kappa {order} as H decreases, as the text"
        " itself says of low loads"
    )


@ERRATA.add(
    "the eps_c correction follows a power law with exponent 0.67",
    "it becomes linear: the excess of counted points is the length of the contact boundary times"
    " the grid spacing",
)
def exponent_of_the_grid(tables: dict[str, Rows]) -> Any:
    last = {}
    for row in sorted(tables["fig1"], key=lambda row: (row["hurst"], row["p_star"], -row["eps_c"])):
        if row.get("kappa_alpha") is not None:
            last[row["hurst"], row["p_star"]] = row
    return last and "finest local exponents: " + ", ".join(
        filled("{kappa_alpha:±} (H = {hurst:g}, p* = {p_star:.3f}, around eps_c = {eps_c:1/})", row)
        for row in last.values()
    )


@ERRATA.add(
    "eq. tfc: the three corrections add up",
    "not at low loads for H > 0: a coarse grid enlarges the fractal correction, so terms fitted at"
    " eps_c = 1/2 must not be taken to eps_c = 0",
)
def terms_do_not_add(tables: dict[str, Rows]) -> Any:
    parts, fractal = [], []
    for hurst, rows in by_hurst(low_high(tables["fig1"])["low"]).items():
        coarse, fine = (
            {row["lam_l_over_lam_s"]: row["kappa"] for row in rows if near(row["eps_c"], eps_c)}
            for eps_c in (0.5, 0.25)
        )
        steps = {f: coarse[f] - fine[f] for f in sorted(coarse.keys() & fine.keys())}
        if len(steps) > 1:
            parts.append(
                f"H = {hurst:g}: "
                + ", ".join(f"{step:.3f} at eps_f = 1/{f:g}" for f, step in steps.items())
            )
    for hurst, rows in by_hurst(low_high(tables["fig2"])["low"]).items():
        first, last = coarsest(rows, "eps_f"), finest(rows, "eps_f")
        if first is not last:
            fractal.append(
                f"{first['kappa'] - last['kappa']:.2f} and"
                f" {first['kappa_edge'] - last['kappa_edge']:.2f} (H = {hurst:g})"
            )
    return parts and (
        f"kappa(eps_c = 1/2) - kappa(1/4): {'; '.join(parts)}. Fall of kappa along the eps_f series"
        f" at eps_c = 1/2, as counted and edge-corrected: {', '.join(fractal)}"
    )


@ERRATA.add(*kappa.fractal_claim())
def fractal_error(tables: dict[str, Rows]) -> Any:
    return kappa.fractal_excess(tables["fig2"])


@ERRATA.computed(
    "expected error of kappa only 6 % (H = 0.8), similarly small for H = 0.3",
    "its own coefficients give more; the second system is no 2048 × 2048 one",
)
def six_percent() -> str:
    parts = []
    for claim in paper.numbers()["reference_error"]:
        eps = {name: claim[name] for name in ("eps_t", "eps_f", "eps_c")}
        total = paper.correction(paper.coefficients("kappa", "low", claim["hurst"]), **eps)
        limit = of_hurst("kappa_tfc", claim["hurst"]) or SLOPE["high"]
        n = 1 / (eps["eps_c"] * eps["eps_f"] * eps["eps_t"])
        parts.append(
            f"H = {claim['hurst']:g}, eps_c = 1/{1 / eps['eps_c']:g}, eps_f ="
            f" 1/{1 / eps['eps_f']:g} (n = {n:.0f}): {total:.3f}, {total / limit:.0%} of {limit:g}"
        )
    return "; ".join(parts)


@ERRATA.add(
    "H = 0.8 at low pressure needs eps_c <= 1/32 for 10 %",
    "its own coefficients reach 10 % at eps_c = 1/2, as the section on the gap says",
)
def grid_needed(tables: dict[str, Rows]) -> Any:
    hurst = paper.numbers()["eps_c_needed"]["hurst"]
    area, gap = (
        longest(
            [row for row in low_high(tables[name])["low"] if near(row["hurst"], hurst)], "eps_c"
        )
        for name in ("fig1", "fig4")
    )
    if not (len(area) > 1 and len(gap) > 1):
        return ""
    terms = {
        "kappa": of_hurst("kappa_tfc", hurst),
        "gap_over_h_rms": coarsest(gap, "eps_c")["gap_over_h_rms"],
    }
    for name, whole in terms.items():
        printed = paper.coefficients(name, "low", hurst)
        terms[name] = printed["C_c"] * 0.5 ** printed["alpha_c"] / whole
    raw, edge, ours = (
        coarsest(rows, "eps_c")[name] / finest(rows, "eps_c")[name] - 1
        for rows, name in ((area, "kappa"), (area, "kappa_edge"), (gap, "gap_over_h_rms"))
    )
    return (
        f"continuum terms at eps_c = 1/2 by the paper's tables: {terms['kappa']:.1%} of kappa,"
        f" {terms['gap_over_h_rms']:.1%} of the gap; ours, against eps_c ="
        f" 1/{1 / finest(area, 'eps_c')['eps_c']:g}: kappa {raw:+.1%} as counted, {edge:+.1%}"
        f" edge-corrected, gap {ours:+.2%}"
    )


@ERRATA.add(
    "contact areas of H near 0 and near 1 differ by no more than about 10 % in the TFC limit",
    "the paper's own slopes differ by more",
)
def spread_over_hurst(tables: dict[str, Rows]) -> Any:
    ours = [
        filled("{kappa_tfc:±} (H = {hurst_number:g})", row)
        for row in where(tables["table5"], area="raw")
    ]
    return (
        f"{SLOPE['high']:g} and {SLOPE['low']:g} differ by {SLOPE['high'] / SLOPE['low'] - 1:.1%}"
        + (f"; ours in the limit, as counted: {', '.join(ours)}" if len(ours) > 1 else "")
    )
