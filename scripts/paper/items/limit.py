"""kappa in the limit of large cells, many decades of roughness and fine grids: does 2 - 2H hold, do
the routes meet?"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hpc_gfmd.plotting.style import COLOURS, figure
from hpc_gfmd.util.errors import SceneError

from ..case import Case
from ..catalogue import Study
from ..draw import points
from ..levels import BOTH, HURST, PRESSURES, at_level, series_of, tfc_series
from ..limits import ALPHA_F, fit_limit
from ..paper import Sayings, numbers, of_hurst, saying
from ..rows import Rows, at_load, families, groups, where
from ..scatter import Scatter
from ..text import filled
from . import curves

MORE = {
    "quick": (),
    "desk": (
        (2, 128, 2, 144, (0.8,)),
        (1, 128, 2, 256, (0.8,)),
        (2, 128, 4, 72, (0.8,)),
        (2, 8192, 2, 1, (0.8,)),
    ),
    "paper": ((2, 256, 4, 256, (0.8,)), (1, 256, 4, 256, (0.8,))),
}  # as in levels.py
ROUTES = {"counted": "kappa", "edge": "kappa_edge"}
LEFT_OUT = 4  # up to so many of the coarsest octaves of eps_f
BASE = {
    "quick": 0,
    "desk": 3,
    "paper": 3,
}  # so many are left out of what is given as the limit: no power law reaches there
# chi2 that 2 - 2H may be above the best exponent, in units of chi2/dof or 1: with more it has a
# chance of one per cent
AGREE = 6.6


def series(level: str) -> list[Case]:
    """The series of tables 1 to 5, and the surfaces of the study "curves", which tell the limit of
    fine grids more sharply."""
    fine = [
        replace(case, p_star=tuple(p for p in BOTH if p in case.p_star))
        for case in curves.series(level)
        if case.hurst in HURST
    ]
    return tfc_series(level) + series_of(MORE, HURST, BOTH)(level) + fine


def limits(runs: Rows, level: str) -> Rows:
    """A row for each H, pressure, route, exponent ("free", "2 - 2H") and number of coarsest octaves
    left out.

    Columns kappa_tfc and its standard error, enlarged where the model does not fit, alpha_f (its
    error where fitted), chi2, dof; base: whether the limit is taken there.
    """
    rows = []
    for _, hurst, part in families(runs):
        octaves = sorted({run["eps_f"] for run in part})
        for route, observable in ROUTES.items():
            scatter = Scatter.of(part, observable)
            for left in range(LEFT_OUT + 1):
                for name, exponent in (
                    ("free", None),
                    ("2 - 2H", float(np.clip(2 - 2 * hurst, *ALPHA_F))),
                ):
                    row = {
                        "hurst": hurst,
                        "p_star": part[0]["p_star"],
                        "route": route,
                        "exponent": name,
                        "left_out": left,
                        "base": left == at_level(BASE, level),
                    }
                    try:
                        rows.append(row | _row(part, octaves, left, observable, scatter, exponent))
                    except (SceneError, IndexError):  # too few octaves, grids or cells
                        continue
    return rows


def _row(
    runs: Rows,
    octaves: list[float],
    left: int,
    observable: str,
    scatter: Scatter,
    exponent: float | None,
) -> dict:
    chosen = [run for run in runs if run["eps_f"] <= octaves[-1 - left] * 1.01]
    fit = fit_limit(chosen, observable, scatter, exponent)
    scale = max(1.0, fit.chi2 / fit.dof) ** 0.5
    return {
        "eps_f_coarsest": octaves[-1 - left],
        "kappa_tfc": fit.kappa,
        "kappa_tfc_se": fit.errors["kappa"] * scale,
        "alpha_f": fit.values["alpha_f"],
        "alpha_f_se": fit.errors["alpha_f"] * scale if exponent is None else None,
        "chi2": fit.chi2,
        "dof": fit.dof,
        "runs": len(chosen),
    }


def conclusions(rows: Rows) -> Rows:
    """For each H and pressure: alpha_f that both routes find, and the limit: with 2 - 2H where that
    agrees, else with what is found.

    kappa_tfc is the mean of both routes, its error that of the routes, half their difference, what
    one octave less changes and, where the exponents disagree, half of what that does, together.
    """
    found = []
    for (p_star, hurst), part in groups(rows, "p_star", "hurst").items():
        group = {(row["route"], row["exponent"], row["left_out"]): row for row in part}
        base: Any = next((row["left_out"] for row in part if row["base"]), None)
        if any((route, name, base) not in group for route in ROUTES for name in ("free", "2 - 2H")):
            continue
        free = [group[route, "free", base] for route in ROUTES]
        error = np.array([row["alpha_f_se"] for row in free])
        alpha = float(np.average([row["alpha_f"] for row in free], weights=error**-2))
        worse = [
            (group[row["route"], "2 - 2H", base]["chi2"] - row["chi2"])
            / max(1.0, row["chi2"] / row["dof"])
            for row in free
        ]
        agrees = max(worse) < AGREE
        names = ("2 - 2H", "free") if agrees else ("free", "2 - 2H")
        ours, other, less = (
            [
                group[route, name, left]["kappa_tfc"]
                for route in ROUTES
                if (route, name, left) in group
            ]
            for name, left in ((names[0], base), (names[1], base), (names[0], base + 1))
        )
        kappa = float(np.mean(ours))
        parts = [
            max(group[route, names[0], base]["kappa_tfc_se"] for route in ROUTES),
            np.diff(ours)[0] / 2,
            np.mean(less) - kappa if less else 0.0,
            0.0 if agrees else (np.mean(other) - kappa) / 2,
        ]
        found.append(
            {
                "hurst": hurst,
                "p_star": p_star,
                "alpha_f": alpha,
                "alpha_f_se": float(error.min()),
                "agrees": agrees,
                "kappa_tfc": kappa,
                "kappa_tfc_se": float(np.hypot.reduce(parts)),
                "counted": ours[0],
                "edge": ours[1],
            }
        )
    return found


def findings(rows: Rows) -> Sayings:
    """The limits beside the paper's, the exponent beside 2 - 2H, and which statements of the paper
    survive."""
    found = conclusions(rows)
    for row in found:
        printed = of_hurst("kappa_tfc", row["hurst"]) if row["p_star"] < 0.1 else None
        yield saying(
            "H = {hurst:g}, p* = {p_star:.3g}" + (f" (paper: {printed:g})" if printed else ""),
            "kappa = {kappa_tfc:±} ({share:.2%}); alpha_f = {alpha_f:±}",
            f"2 - 2H = {{expected:g}} {'agrees' if row['agrees'] else 'does not hold here'}; "
            "as counted {counted:.4f}, edge-corrected {edge:.4f}",
            **row,
            share=row["kappa_tfc_se"] / row["kappa_tfc"],
            expected=2 - 2 * row["hurst"],
        )
    apart = [(row["counted"] - row["edge"]) / row["kappa_tfc"] for row in found]
    yield saying(
        "as counted and edge-corrected, which must meet",
        f"apart by {np.max(np.abs(apart), initial=0):.2%} at most",
    )
    yield from of_the_paper(found)


def of_the_paper(found: Rows) -> Sayings:
    """What survives: the printed limits, that they fall with H, that one exponent holds for all
    H."""
    for row in found:
        printed = of_hurst("kappa_tfc", row["hurst"]) if row["p_star"] < 0.1 else None
        if printed:
            off = row["kappa_tfc"] - printed
            yield saying(
                "of the paper: kappa = {printed:g} at H = {hurst:g}, p* = {p_star:.3g}",
                "ours is {off:+.3f} from it",
                "survives" if abs(off) < 2 * row["kappa_tfc_se"] else "does not survive",
                **row,
                printed=printed,
                off=off,
            )
    for p_star, part in groups(found, "p_star").items():
        falls = all(np.diff([row["kappa_tfc"] for row in part]) < 0)
        yield saying(
            "of the paper: kappa falls as H grows, p* = {p_star:.3g}",
            "by {share:.0%} from H = {low:g} to {high:g}",
            "survives" if falls else "does not survive",
            p_star=p_star,
            low=part[0]["hurst"],
            high=part[-1]["hurst"],
            share=1 - part[-1]["kappa_tfc"] / part[0]["kappa_tfc"],
        )
    exponent = numbers()["alpha_f"]
    against = [row for row in found if abs(row["alpha_f"] - exponent) > 2 * row["alpha_f_se"]]
    yield saying(
        f"of the paper: one exponent alpha_f = {exponent:g} for all H",
        ", ".join(filled("{alpha_f:±} at H = {hurst:g}, p* = {p_star:.3g}", row) for row in against)
        or "agrees",
        (
            "does not survive: these are off by more than two standard errors"
            if against
            else "survives"
        ),
    )


def draw(rows: Rows, path: Path) -> None:
    """The limit against the coarsest eps_f that is kept, both routes and both exponents."""
    with figure(path, 8.4, 5.0) as fig:
        axes = fig.subplots(2, len(HURST), squeeze=False)
        for line, (pressure, p_star) in zip(axes, PRESSURES.items(), strict=True):
            for ax, hurst in zip(line, HURST, strict=True):
                for shade, route in zip(COLOURS, ROUTES, strict=False):
                    for shift, (name, mark) in enumerate((("free", "s"), ("2 - 2H", "o"))):
                        part = [
                            row | {"at": row["left_out"] + 0.12 * shift + 0.24 * (route == "edge")}
                            for row in where(
                                at_load(rows, p_star), hurst=hurst, route=route, exponent=name
                            )
                        ]
                        points(
                            ax,
                            part,
                            "at",
                            "kappa_tfc",
                            shade,
                            mark,
                            name == "free",
                            f"{route}, {name}",
                        )
                for row in where(at_load(conclusions(rows), p_star), hurst=hurst):
                    kappa, error = row["kappa_tfc"], row["kappa_tfc_se"]
                    ax.axhspan(kappa - error, kappa + error, color="0.88", zorder=0)
                    ax.set_ylim(kappa - 6 * error, kappa + 6 * error)
                ax.set(title=f"$H = {hurst:g}$" if pressure == "low" else None)
            line[0].set_ylabel(r"$\kappa$ in the limit, $p^* = " + f"{p_star:.3g}$")
        for ax in axes[1]:
            ax.set_xlabel("octaves left out")
        fig.legend(*axes[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=4)


QUESTION = """What is kappa = a_r/p\\* in the limit of large cells, many decades of roughness and fine grids? kappa = kappa_TFC +
C_t eps_t + (C_f + D eps_c) eps_f^alpha_f + C_1 eps_c + C_2 eps_c² + C_3 eps_c³ is fitted to all runs of an H and
p\\*, with the covariance of runs that share a surface; once with a free alpha_f, once with 2 - 2H, the share of the
mean square slope that missing long waves would have; with the coarsest eps_f left out, one octave after the other;
as counted and edge-corrected."""

STUDIES = (
    Study(
        "limit",
        "kappa in the thermodynamic, fractal and continuum limit",
        "2.16 (H = 0) to 1.93 (H = 0.8) with eps_f^0.67",
        series,
        limits,
        draw,
        findings,
        QUESTION,
        {
            "H": "{hurst:g}",
            "p*": "{p_star:.3g}",
            "area": "{route}",
            "exponent": "{exponent}",
            "eps_f from": "{eps_f_coarsest:1/}",
            "kappa in the limit": "{kappa_tfc:±}",
            "alpha_f": "{alpha_f:±}",
            "chi²/dof": "{chi2:.0f}/{dof}",
        },
    ),
)
