"""The linear equations of a soap film over holes: conjugate gradients, preconditioned by multigrid
over aggregates of points.
"""

from typing import Any

import numpy as np

DIRECT = 5000  # unknowns that are solved for by factorisation
TOLERANCE = 1e-11  # of the residual, relative to the right-hand side
STEPS = 400
DAMPING = 0.8  # of Jacobi's smoothing steps: the matrix is that of Laplace, or weaker
SMOOTHING = 2  # steps, before and after the coarse grid
OVERCORRECTION = 1.8  # constant pieces are stiffer than the film


class FilmLevel:
    """One level of the multigrid.

    parents: index in the next coarser level of the aggregate of each point; None on the coarsest
    level, which has `factors` of its matrix; `weights`: DAMPING over the diagonal of the matrix.
    """

    def __init__(self, matrix: Any, parents: np.ndarray | None) -> None:
        from scipy.sparse.linalg import splu

        self.matrix = matrix
        self.weights = DAMPING / matrix.diagonal()
        self.parents = parents
        self.factors: Any = splu(matrix.tocsc()) if parents is None else None


def solve_film(matrix: Any, right: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Solve matrix z = right (symmetric, positive definite) for the heights z of points x, y in
    holes.

    Raises MemoryError if the factorisation does not fit into memory, ArithmeticError without
    convergence.
    """
    from scipy.sparse.linalg import LinearOperator, cg, spsolve

    if len(right) <= DIRECT:
        return np.atleast_1d(spsolve(matrix.tocsc(), right))
    levels = _levels(matrix, x, y)
    cycle = LinearOperator(matrix.shape, lambda residual: _cycle(levels, 0, residual), dtype=float)
    heights, steps = cg(matrix, right, rtol=TOLERANCE, atol=0.0, maxiter=STEPS, M=cycle)
    if steps:
        raise ArithmeticError(f"filling holes did not converge in {steps} steps")
    return heights


def _levels(matrix: Any, x: np.ndarray, y: np.ndarray) -> list[FilmLevel]:
    """Build the levels, finest first, to at most DIRECT points: points within 2 x 2 grid points
    become one on the next level.
    """
    from scipy.sparse import csr_array

    levels = []
    while len(x) > DIRECT:
        x = x // 2
        y = y // 2
        places = x * (int(y.max()) + 1) + y
        _, members, parents = np.unique(places, return_index=True, return_inverse=True)
        levels.append(FilmLevel(matrix, parents))
        x = x[members]
        y = y[members]
        shape = (len(parents), len(members))
        ones = np.ones(len(parents))
        aggregates = csr_array((ones, (np.arange(len(parents)), parents)), shape=shape)
        matrix = (aggregates.T @ matrix @ aggregates).tocsr()
    levels.append(FilmLevel(matrix, None))
    return levels


def _cycle(levels: list[FilmLevel], depth: int, residual: np.ndarray) -> np.ndarray:
    """Return an approximate solution of the equations of levels[depth] by one symmetric V-cycle."""
    level = levels[depth]
    residual = residual.ravel()
    if level.parents is None:
        return level.factors.solve(residual)
    solution = level.weights * residual
    for _ in range(SMOOTHING - 1):
        solution += level.weights * (residual - level.matrix @ solution)
    rest = residual - level.matrix @ solution
    coarse = np.bincount(level.parents, rest, len(levels[depth + 1].weights))
    correction = _cycle(levels, depth + 1, coarse)
    solution += OVERCORRECTION * correction[level.parents]
    for _ in range(SMOOTHING):
        solution += level.weights * (residual - level.matrix @ solution)
    return solution
