"""Figure 1: kappa against eps_c."""

from .. import draw as draw_with
from .. import fits, paper
from ..averages import average, low_high
from ..compare import PRINTED, by_hurst, coarsest, finest, longest
from ..levels import eps_c_series
from ..paper import of_hurst, quoted, saying

NAME = "fig1"
TITLE = "kappa against eps_c"
PAPER = "kappa falls as eps_c^0.67 to about 2 at p* = 0.007, and below 2 at 0.353; eps_t = 1/2, eps_f = 1/1024"


def cases(level):
    """The contacts that it is made of."""
    return eps_c_series(level)


def tabulate(runs, level):
    """Means over realisations of kappa, as counted and edge-corrected; where the series is long enough, alpha_c between neighbouring
    octaves of paired differences (NAME_alpha, NAME_alpha_se)."""
    rows = average(runs, ("kappa", "kappa_edge"))
    for hurst, p_star in sorted({(row["hurst"], row["p_star"]) for row in rows}):
        chosen = [row for row in rows if (row["hurst"], row["p_star"]) == (hurst, p_star)]
        fine = longest(chosen, "eps_c", "lam_l_over_lam_s")
        part = [run for run in runs if (run["hurst"], run["p_star"]) == (hurst, p_star)]
        for observable in ("kappa", "kappa_edge"):
            for local in fits.local_exponents(part, observable, level):
                row = next(row for row in fine if row["eps_c"] == local["eps_c"])
                row |= {f"{observable}_alpha": local["alpha"], f"{observable}_alpha_se": local["alpha_se"]}
    return rows


def draw(rows, path):
    """kappa against eps_c; marks tell eps_f."""
    draw_with.two_pressures(path, rows, "eps_c", "kappa", edge=True, theory=draw_with.kappa_lines)


def compare(rows):
    """The exponent alpha_c, and the contact area that the text gives."""
    lines = []
    for pressure, part in low_high(rows).items():
        for hurst, chosen in by_hurst(part).items():
            known = [row for row in longest(chosen, "eps_c", "lam_l_over_lam_s") if row.get("kappa_alpha") is not None]
            if known:
                first, last = coarsest(known, "eps_c"), finest(known, "eps_c")
                lines.append(
                    saying(
                        f"H = {hurst:g}, {PRINTED[pressure]}: alpha_c = {paper.numbers()['alpha_c']:g}",
                        f"{quoted(first['kappa_alpha'], first['kappa_alpha_se'])} around eps_c = 1/{1 / first['eps_c']:g}, "
                        f"{quoted(last['kappa_alpha'], last['kappa_alpha_se'])} around 1/{1 / last['eps_c']:g}",
                        "a contact boundary of finite length makes the excess of counted points linear in eps_c for eps_c -> 0",
                    )
                )
    for hurst, chosen in by_hurst(low_high(rows)["high"]).items():
        printed = of_hurst("area_high", hurst)
        if printed and chosen:
            other = next(a_r for name, a_r in paper.numbers()["area_high"].items() if name != f"{hurst:g}")
            p_star = chosen[0]["p_star"]
            a_r = {name: finest(chosen, "eps_c")[name] * p_star for name in ("kappa", "kappa_edge")}
            lines.append(
                saying(
                    f"a_r = {printed:g} at H = {hurst:g}, {PRINTED['high']}",
                    f"a_r = {a_r['kappa']:.3f} as counted, {a_r['kappa_edge']:.3f} edge-corrected, on the finest grid",
                    f"printed is kappa/2, which is a_r = {2 * printed * p_star:.3f}; the number printed for the other H is a_r = "
                    f"{2 * other * p_star:.3f}",
                )
            )
    return lines
