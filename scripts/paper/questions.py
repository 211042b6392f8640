"""What the paper leaves open: kappa in the TFC limit by two routes, the exponents alpha_c and
alpha_f, and what the missing factor of Persson's theory explains."""

from typing import Any

from hpc_gfmd.util.errors import SceneError

from . import fits, paper
from .items.gap import share_explained
from .levels import PRESSURES
from .limits import compare_routes
from .rows import Rows, families, fine_half
from .text import filled, quoted, table

SHARPEST = 0.125  # eps_c from which on alpha_c is fitted as its asymptotic value
FAMILY = {"H": "{hurst:g}", "p*": "{p_star:.3f}"}

LIMITS = """### kappa in the TFC limit

Fit of kappa = kappa_TFC + C_t eps_t + (C_f + D eps_c) eps_f^alpha_f + C_1 eps_c + C_2 eps_c² + C_3 eps_c³ to all runs of \
an H and p*, with the covariance of runs that share a surface. alpha_f is common to the two ways of counting the area \
(alone: what each finds, as counted; edge-corrected). The error holds realisations, solver, alpha_f, and the change when \
the coarsest third of the eps_f is left out. Both routes see the same contacts, so their difference is known better than \
either; it is given in units of its own error. Last: the limits with the paper's alpha_f and the errors that it would \
seem to have.

{table}

2 - 2H is the exponent of the share that waves longer than lam_l, which are missing at finite eps_f, have in the mean \
square slope of a surface with more decades: the approach to the fractal limit is the slower the larger H. Where alpha_f is small, the \
limit is an extrapolation over many decades. These are the runs of the paper's series alone; the limits to use are \
those of [all runs](limit.md), which go on to finer grids and more decades."""

ALPHA_C = """### The exponent alpha_c

Local exponents log2 of the ratio of successive differences of the same surfaces (in brackets: the middle one of the \
three grids; jackknife over seeds), and fits of limit + C eps_c^alpha_c along the longest series, to all grids and to those with \
eps_c <= {sharpest:g}. The paper: {printed:g}. The excess of counted points is the length of the contact boundary times a, so the \
exponent as counted should tend to 1 for eps_c -> 0. The edge correction takes most of it off, and what is left may have either sign: \
"-" where the steps change sign or no power law fits.

{table}"""

THEORY = """### "Theory is 2 to 3 times too small at high pressure"

Simulation over Persson theory (gap/h_rms, gamma = 0.42), as printed and with the missing factor 2; explained: the \
share of the logarithm of the printed ratio that the factor removes. At p* = 0.007 the factor enlarges the theory, too.

{table}"""


def section(runs: Rows, tables: dict[str, Rows], level: str) -> str:
    """The section of the report; runs: those of levels.tfc_series, tables: {study: rows}."""
    alpha_c = ALPHA_C.format(
        sharpest=SHARPEST, printed=paper.numbers()["alpha_c"], table=_alpha_c(runs, level)
    )
    theory = _theory(tables["fig6"])
    parts = [
        "## Open questions",
        LIMITS.format(table=_limits(runs)),
        alpha_c,
        theory and THEORY.format(table=theory),
    ]
    return "\n\n".join(part for part in parts if part)


def _limits(runs: Rows) -> str:
    one = {
        "raw": "{kappa_tfc:±}",
        "alone": "{alpha_f_own:±}",
        "theirs": "{kappa_paper_alpha:±}",
        "chi2": "{chi2_per_dof:.2f}",
    }
    rows = []
    for pressure, hurst, part in families(runs):
        row = {
            "hurst": hurst,
            "p_star": PRESSURES[pressure],
            "expected": 2 - 2 * hurst,
            "paper": (pressure == "low" and paper.of_hurst("kappa_tfc", hurst)) or "",
        }
        try:
            raw, edge = compare_routes(part)
        except SceneError as error:
            rows.append(
                {"hurst": hurst, "p_star": PRESSURES[pressure], "raw": f"not yet ({error})"}
            )
            continue
        both = {
            name: "; ".join(filled(cell, route) for route in (raw, edge))
            for name, cell in one.items()
        }
        rows.append(
            raw
            | row
            | both
            | {
                "raw": filled(one["raw"], raw),
                "edge": filled(one["raw"], edge),
                "sigmas": raw["difference"] / raw["difference_se"],
            }
        )
    return table(
        rows,
        FAMILY
        | {
            "as counted": "{raw}",
            "edge-corrected": "{edge}",
            "difference": "{difference:+.4f}",
            "in its sigma": "{sigmas:+.1f}",
            "paper": "{paper}",
            "alpha_f": "{alpha_f:±}",
            "alone": "{alone}",
            "2 - 2H": "{expected:g}",
            f"with alpha_f = {paper.numbers()['alpha_f']:g}": "{theirs}",
            "chi²/dof": "{chi2}",
        },
    )


def _alpha_c(runs: Rows, level: str) -> str:
    rows = []
    for pressure, hurst, part in families(runs):
        row: dict[str, Any] = {"hurst": hurst, "p_star": PRESSURES[pressure]}
        for observable in ("kappa", "kappa_edge"):
            local = (
                x for x in fits.local_exponents(part, observable, level) if x["alpha"] is not None
            )
            row[observable] = ", ".join(filled("{alpha:±} ({eps_c:1/})", x) for x in local)
            row[f"{observable}_all"], row[f"{observable}_fine"] = (
                _exponent(part, observable, level, coarsest) for coarsest in (0.5, SHARPEST)
            )
        rows.append(row)
    return table(
        rows,
        FAMILY
        | {
            "local, as counted": "{kappa}",
            "fit, all": "{kappa_all}",
            "fit, fine grids": "{kappa_fine}",
            "local, edge-corrected": "{kappa_edge}",
            "fit, fine grids, edge-corrected": "{kappa_edge_fine}",
        },
    )


def _exponent(runs: Rows, observable: str, level: str, coarsest: float) -> str:
    try:
        fit = fits.exponent_c(runs, observable, level, coarsest)
    except SceneError:
        return "-"
    found = fit.alpha["c"], fit.sigma["alpha_c"]
    return quoted(*found) if fits.is_power_law(*found) else "-"


def _theory(fig6: Rows) -> Any:
    rows = []
    for pressure, hurst, part in families(fig6):
        for row in sorted(fine_half(part), key=lambda row: -row["eps_f"]):
            rows.append(
                row
                | {
                    "explained": f"{share_explained([row]):.0%}" if pressure == "high" else "",
                    "paper": (
                        paper.of_hurst("theory_factor_h_rms", hurst)
                        if pressure == "high"
                        else "1 within 10 %"
                    ),
                }
            )
    return rows and table(
        rows,
        FAMILY
        | {
            "eps_f": "{eps_f:1/}",
            "gap/h_rms": "{gap_over_h_rms:±}",
            "over printed": "{over_persson_printed:.3f}",
            "over corrected": "{over_persson:.3f}",
            "explained": "{explained}",
            "paper": "{paper}",
        },
    )
