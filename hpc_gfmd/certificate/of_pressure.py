"""The certificate of a pressure instead of a gap, solved elsewhere in a part of the surface.

g = S p + h, moved so that closed points are at 0 in the mean; what is left of their gap is set to
0, and the errors grow by the largest pressure that this may take, and by what the load lacks.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from ..kernels.certify import KktSums, kkt_residuals
from ..operators.elastic import Elastic, reader
from .certificate import Certificate, Recomputed, measured

if TYPE_CHECKING:
    from ..operators.multilevel import Multilevel
    from ..operators.problem import Problem
    from ..operators.state import State


class Part(NamedTuple):
    """The pressure on this rank's points of a part of the surface, beyond which it is 0."""

    rows: slice | np.ndarray  # local, or of each point; none on a rank that has none of the part
    columns: slice | np.ndarray  # local, or of each point
    p: np.ndarray
    closed: np.ndarray  # bool, which of the points are in contact


def certify_pressure(
    problem: Problem, part: Part, state: State, levels: Multilevel, dtype: DTypeLike, dual: bool
) -> tuple[Certificate, float]:
    """Set a state to the pressure of a part; return its certificate, and a bound of the neglected
    pressure over p. Collective, one FFT pair.

    g < 0 where points beyond the part penetrate. Needs stored heights, without hardness or
    attraction; overwrites the levels.
    """
    grid = problem.grid
    g = state.g
    p = state.p
    _spread(part, p)
    elastic = Elastic(grid, problem.body, dtype)

    elastic.pressure_rows(reader(p))
    uKu = elastic.columns(inverse=True)
    level = _gap(problem, elastic, part, g)
    penetration, squares = _close(part, g)

    def look(i0: int, i1: int) -> tuple[KktSums, float]:
        worst = np.zeros(g.shape[1])
        x = p[i0:i1].astype(dtype)
        return kkt_residuals(g, p, x, 0.0, None, grid.inside, i0, i1, worst)

    looks = grid.by_rows(look)
    sums = [of_rows for of_rows, _ in looks] or [KktSums(*[0.0] * len(KktSums._fields))]
    load = part.p.sum(dtype=np.float64)
    *totals, squares, uKu, load = grid.comm.sum([*np.sum(sums, axis=0), squares, uKu, load])
    tension = max((tension for _, tension in looks), default=0.0)
    tension, penetration = grid.comm.max([tension, penetration]).tolist()
    state.uKu = float(uKu)
    recomputed = Recomputed(KktSums(*totals), tension, mean=-level)
    stiffest = problem.body.bounds(grid)[1]
    neglected = stiffest * float(np.sqrt(squares / max(recomputed.sums.closed_pp, 1e-300)))
    missing = abs(float(load) / (grid.N * problem.p0) - 1)
    certificate = measured(problem, elastic, state, recomputed, penetration, levels, dual)
    certificate = replace(
        certificate,
        load_balance=max(certificate.load_balance, missing),
        errors=_with_neglected(certificate.errors, neglected + missing),
    )
    return certificate, neglected + missing


def _with_neglected(
    errors: tuple[float, float, float], neglected: float
) -> tuple[float, float, float]:
    """Return errors that grow with the relative pressure `neglected`, and as its square."""
    area, gap, pressure = errors
    growth = 1 + neglected / pressure if pressure > 0 else 1.0
    return area * growth, gap * growth**2, pressure + neglected


def _spread(part: Part, p: np.ndarray) -> None:
    p[...] = 0
    p[part.rows, part.columns] = part.p


def _gap(problem: Problem, elastic: Elastic, part: Part, g: np.ndarray) -> float:
    """Set g to the pressure's gap, of mean 0 at closed points; return the move. Collective."""
    grid = problem.grid
    rows, points = grid.inside
    h = problem.heights

    def add(i0: int, i1: int, u: np.ndarray) -> None:
        g[i0:i1] = u[: i1 - i0]
        inner = max(min(i1, rows) - i0, 0)
        g[i0 : i0 + inner, :points] += h[i0 : i0 + inner]

    elastic.use_rows(add)
    closed = g[part.rows, part.columns][part.closed]
    total, count = grid.comm.sum([closed.sum(dtype=np.float64), closed.size])
    level = float(total / max(count, 1))

    def move(i0: int, i1: int) -> None:
        g[i0:i1] -= g.dtype.type(level)

    grid.by_rows(move)
    return level


def _close(part: Part, g: np.ndarray) -> tuple[float, float]:
    """Make the part's gap feasible; return the largest penetration and the sum of squares."""
    of_part = g[part.rows, part.columns]
    feasible = np.where(part.closed, 0, np.maximum(of_part, 0))
    change = np.subtract(feasible, of_part, dtype=np.float64)
    g[part.rows, part.columns] = feasible
    return float(change.max(initial=0.0)), float(np.vdot(change, change))
