"""Table 5: kappa of different authors, and ours in the TFC limit."""

from ...errors import SceneError
from .. import draw as draw_with
from .. import paper
from ..averages import near
from ..levels import P_LOW, tfc_series
from ..limits import compare_routes
from ..paper import quoted, saying

NAME = "table5"
TITLE = "kappa of different authors, and ours in the TFC limit"
PAPER = "kappa at p/E* of about 0.01, 1976 to 2013; the paper's own 2.16 (H = 0) to 1.93 (H = 0.8)"


def cases(level):
    """The contacts that it is made of."""
    return tfc_series(level)


def tabulate(runs, level):
    """The paper's table, and our limits as counted (area "raw") and edge-corrected ("edge").

    kappa_tfc_se: realisations, solver and model together; difference, difference_se: raw minus edge-corrected; alpha_f: the fitted
    exponent.
    """
    rows = [{"area": "literature", "hurst_number": None} | entry for entry in paper.numbers()["literature"]]
    rows += [
        {"area": "paper", "hurst_number": float(hurst), "kappa_tfc": kappa} for hurst, kappa in paper.numbers()["kappa_tfc"].items()
    ]
    for hurst in sorted({run["hurst"] for run in runs}):
        part = [run for run in runs if run["hurst"] == hurst and near(run["p_star"], P_LOW)]
        try:
            raw, edge, difference, sigma = compare_routes(part)
        except SceneError:  # too few runs yet
            continue
        for area, limit in (("raw", raw), ("edge", edge)):
            rows.append(
                {"area": area, "authors": "this code", "hurst_number": hurst}
                | limit.row()
                | {"difference": difference, "difference_se": sigma}
            )
    return rows


def draw(rows, path):
    """kappa in the TFC limit against H."""
    draw_with.limits(path, rows)


def compare(rows):
    """Our limits beside the paper's."""
    lines = []
    for row in (row for row in rows if row["area"] == "raw"):
        edge = next(r for r in rows if r["area"] == "edge" and r["hurst_number"] == row["hurst_number"])
        printed = paper.of_hurst("kappa_tfc", row["hurst_number"])
        lines.append(
            saying(
                f"H = {row['hurst_number']:g}: kappa = {printed:g} in the TFC limit"
                if printed
                else f"H = {row['hurst_number']:g}: no number printed",
                f"{quoted(row['kappa_tfc'], row['kappa_tfc_se'])} as counted, {quoted(edge['kappa_tfc'], edge['kappa_tfc_se'])} "
                f"edge-corrected; "
                f"the routes differ by {row['difference'] / row['difference_se']:+.1f} sigma",
                f"alpha_f = {quoted(edge['alpha_f'], edge['alpha_f_se'])} instead of {paper.numbers()['alpha_f']:g}",
            )
        )
    return lines
