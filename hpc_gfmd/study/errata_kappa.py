"""Errata of what the paper says about the contact area, each shown by the rows of our figures and tables.

Every function takes {study: rows} and returns {"printed", "right", "shown"}, or None where the rows do not reach that far yet.
"""

from . import paper
from .averages import low_high, near
from .compare import by_hurst, coarsest, finest, longest
from .errata_method import erratum
from .items import fig2
from .levels import P_HIGH, P_LOW
from .paper import of_hurst


def area_is_half_kappa(tables):
    """The contact area at the high pressure."""
    chosen = by_hurst(low_high(tables["fig1"])["high"])
    numbers = paper.numbers()["area_high"]
    found = {h: finest(rows, "eps_c") for h, rows in chosen.items() if of_hurst("area_high", h)}
    if len(found) < len(numbers):
        return None
    ours = ", ".join(
        f"a_r = {row['kappa_edge'] * P_HIGH:.3f}, kappa/2 = {row['kappa_edge'] / 2:.3f} at H = {h:g}" for h, row in found.items()
    )
    order = "rises" if found[min(found)]["kappa_edge"] > found[max(found)]["kappa_edge"] else "falls"
    return erratum(
        "a_r from 0.837 for H = 0.8 to 0.802 for H = 0 at p* = 0.353",
        "these are kappa/2, and the two H are exchanged",
        f"edge-corrected on the finest grid: {ours}; kappa {order} as H decreases, as the text itself says of low loads",
    )


def exponent_of_the_grid(tables):
    """alpha_c."""
    known = [row for row in tables["fig1"] if row.get("kappa_alpha") is not None]
    last = [
        finest([r for r in known if (r["hurst"], r["p_star"]) == key], "eps_c")
        for key in sorted({(r["hurst"], r["p_star"]) for r in known})
    ]
    parts = [
        f"{paper.quoted(row['kappa_alpha'], row['kappa_alpha_se'])} (H = {row['hurst']:g}, p* = {row['p_star']:.3f}, around eps_c = "
        f"1/{1 / row['eps_c']:g})"
        for row in last
    ]
    return parts and erratum(
        "the eps_c correction follows a power law with exponent 0.67",
        "it becomes linear: the excess of counted points is the length of the contact boundary times the grid spacing",
        "finest local exponents: " + ", ".join(parts),
    )


def terms_do_not_add(tables):
    """Whether the correction of the grid depends on eps_f, and the fractal one on how the area is counted."""
    parts = []
    for hurst, rows in by_hurst(low_high(tables["fig1"])["low"]).items():
        steps = {}
        for row in rows:
            finer = next(
                (r for r in rows if r["lam_l_over_lam_s"] == row["lam_l_over_lam_s"] and near(r["eps_c"], row["eps_c"] / 2)), None
            )
            if near(row["eps_c"], 0.5) and finer:
                steps[row["lam_l_over_lam_s"]] = row["kappa"] - finer["kappa"]
        if len(steps) > 1:
            parts.append(f"H = {hurst:g}: " + ", ".join(f"{steps[f]:.3f} at eps_f = 1/{f:g}" for f in sorted(steps)))
    fractal = []
    for hurst, rows in by_hurst(low_high(tables["fig2"])["low"]).items():
        first, last = coarsest(rows, "eps_f"), finest(rows, "eps_f")
        if first is not last:
            fractal.append(f"{first['kappa'] - last['kappa']:.2f} and {first['kappa_edge'] - last['kappa_edge']:.2f} (H = {hurst:g})")
    return parts and erratum(
        "eq. tfc: the three corrections add up",
        "not at low loads for H > 0: a coarse grid enlarges the fractal correction, so terms fitted at eps_c = 1/2 must not be taken "
        "to eps_c "
        "= 0",
        "kappa(eps_c = 1/2) - kappa(1/4): "
        + "; ".join(parts)
        + ". Fall of kappa along the eps_f series at eps_c = 1/2, as counted and edge-corrected: "
        + ", ".join(fractal),
    )


def thirty_percent(tables):
    """The fractal error of kappa that the text gives."""
    lines = fig2.compare(tables["fig2"])
    return lines and erratum(lines[0]["paper"], lines[0]["why"], lines[0]["ours"])


def six_percent(_tables):
    """The errors that the text expects of two recommended systems, by its own table."""
    parts = []
    for claim in paper.numbers()["reference_error"]:
        row = paper.coefficients("kappa", P_LOW, claim["hurst"])
        total = sum(row[f"C_{i}"] * claim[f"eps_{i}"] ** row[f"alpha_{i}"] for i in "cft")
        limit = of_hurst("kappa_tfc", claim["hurst"]) or paper.numbers()["slope"]["high"]
        n = 1 / (claim["eps_c"] * claim["eps_f"] * claim["eps_t"])
        parts.append(
            f"H = {claim['hurst']:g}, eps_c = 1/{1 / claim['eps_c']:g}, eps_f = 1/{1 / claim['eps_f']:g} (n = {n:.0f}): {total:.3f}, "
            f"{total / limit:.0%} of {limit:g}"
        )
    return erratum(
        "expected error of kappa only 6 % (H = 0.8), similarly small for H = 0.3",
        "its own coefficients give more; the second system is no 2048 × 2048 one",
        "; ".join(parts),
    )


def grid_needed(tables):
    """The grid that reference data at H = 0.8 and low load need."""
    claim = paper.numbers()["eps_c_needed"]
    row = paper.coefficients("gap_over_h_rms", P_LOW, claim["hurst"])
    area = paper.coefficients("kappa", P_LOW, claim["hurst"])
    own = area["C_c"] * 0.5 ** area["alpha_c"] / of_hurst("kappa_tfc", claim["hurst"])
    series = {name: longest(_of(tables[name], claim["hurst"]), "eps_c", "lam_l_over_lam_s") for name in ("fig1", "fig4")}
    if not all(len(rows) > 1 for rows in series.values()):
        return None
    gap = row["C_c"] * 0.5 ** row["alpha_c"] / coarsest(series["fig4"], "eps_c")["gap_over_h_rms"]
    measured = [
        coarsest(series[n], "eps_c")[o] / finest(series[n], "eps_c")[o] - 1
        for n, o in (("fig1", "kappa"), ("fig1", "kappa_edge"), ("fig4", "gap_over_h_rms"))
    ]
    return erratum(
        "H = 0.8 at low pressure needs eps_c <= 1/32 for 10 %",
        "its own coefficients reach 10 % at eps_c = 1/2, as the section on the gap says",
        f"continuum terms at eps_c = 1/2 by the paper's tables: {own:.1%} of kappa, {gap:.1%} of the gap; ours, against eps_c = 1/"
        f"{1 / finest(series['fig1'], 'eps_c')['eps_c']:g}: kappa {measured[0]:+.1%} as counted, {measured[1]:+.1%} edge-corrected, "
        f"gap {measured[2]:+.2%}",
    )


def spread_over_hurst(tables):
    """How much kappa depends on H."""
    slope = paper.numbers()["slope"]
    ours = [row for row in tables["table5"] if row["area"] == "raw"]
    found = (
        ""
        if len(ours) < 2
        else "; ours in the limit, as counted: "
        + ", ".join(f"{paper.quoted(r['kappa_tfc'], r['kappa_tfc_se'])} (H = {r['hurst_number']:g})" for r in ours)
    )
    return erratum(
        "contact areas of H near 0 and near 1 differ by no more than about 10 % in the TFC limit",
        "the paper's own slopes differ by more",
        f"{slope['high']:g} and {slope['low']:g} differ by {slope['high'] / slope['low'] - 1:.1%}{found}",
    )


def _of(rows, hurst, pressure="low"):
    return [row for row in low_high(rows)[pressure] if near(row["hurst"], hurst)]


ERRATA = (area_is_half_kappa, exponent_of_the_grid, terms_do_not_add, thirty_percent, six_percent, grid_needed, spread_over_hurst)
