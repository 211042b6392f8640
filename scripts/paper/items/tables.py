"""Tables 1 to 4: coefficients of eq. tfc; table 5: kappa in the limit, beside other authors'."""

from functools import partial
from typing import Any

from hpc_gfmd.util.errors import SceneError

from .. import coefficients, draw, paper
from ..catalogue import Study
from ..levels import HURST_GAP, tfc_series
from ..limits import compare_routes
from ..paper import Sayings, of_hurst, saying
from ..rows import Rows, by_hurst, low_high, where
from ..text import filled


def limits(runs: Rows, level: str) -> Rows:
    """The paper's table, and our limits (limits.compare_routes) as counted (area "raw") and
    edge-corrected ("edge")."""
    numbers = paper.numbers()
    rows = [{"area": "literature", "hurst_number": None} | entry for entry in numbers["literature"]]
    rows += [
        {"area": "paper", "hurst_number": float(hurst), "kappa_tfc": kappa}
        for hurst, kappa in numbers["kappa_tfc"].items()
    ]
    for hurst, part in by_hurst(low_high(runs)["low"]).items():
        try:
            routes = compare_routes(part)
        except SceneError:  # too few runs yet
            continue
        rows += [
            {"area": area, "authors": "this code", "hurst_number": hurst} | route
            for area, route in zip(("raw", "edge"), routes, strict=True)
        ]
    return rows


def our_limits(rows: Rows) -> Sayings:
    """Our limits beside the paper's."""
    for raw, edge in zip(where(rows, area="raw"), where(rows, area="edge"), strict=True):
        printed = of_hurst("kappa_tfc", raw["hurst_number"])
        yield saying(
            "H = {hurst_number:g}: "
            + (f"kappa = {printed:g} in the TFC limit" if printed else "no number printed"),
            filled("{kappa_tfc:±} as counted, ", raw)
            + "{kappa_tfc:±} edge-corrected; the routes differ by {sigmas:+.1f} sigma",
            f"alpha_f = {{alpha_f:±}} instead of {paper.numbers()['alpha_f']:g}",
            **edge,
            sigmas=edge["difference"] / edge["difference_se"],
        )


def _coefficients(name: str, observable: str, pressure: str, remark: str = "") -> Study:
    what: Any = {"observable": observable, "pressure": pressure}
    label = {"gap_over_h_rms": "gap/h_rms"}.get(observable, observable)
    return Study(
        name,
        f"coefficients of eq. tfc for {label} at p* = {paper.PRINTED[pressure]}",
        f"C_i, alpha_i for H = 0.3, 0.5, 0.8{remark}",
        partial(tfc_series, hurst=HURST_GAP),
        partial(coefficients.table_rows, **what),
        draw.coefficients,
        partial(coefficients.compare, **what),
    )


STUDIES = (
    _coefficients("table1", "kappa", "low"),
    _coefficients("table2", "kappa", "high"),
    _coefficients("table3", "gap_over_h_rms", "low"),
    _coefficients("table4", "gap_over_h_rms", "high", "; the printed caption has the wrong p*"),
    Study(
        "table5",
        "kappa of different authors, and ours in the TFC limit",
        "kappa at p/E* of about 0.01, 1976 to 2013; the paper's own 2.16 (H = 0) to 1.93 (H = 0.8)."
        " Ours by the runs of the paper's series alone; the limits to use: [all runs](limit.md)",
        tfc_series,
        limits,
        draw.limits,
        our_limits,
    ),
)
