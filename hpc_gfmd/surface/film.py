"""Equations of a soap film over holes: conjugate gradients, preconditioned by multigrid over
aggregates of points (in single precision). A point has at most four neighbours, to each of which a
bond pulls it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

DIRECT = 5000  # unknowns that are solved for by factorisation
TOLERANCE = 1e-11  # of the residual, relative to the right-hand side
STEPS = 400
DAMPING = 0.8  # of Jacobi's smoothing steps: the matrix is that of Laplace, or weaker
SMOOTHING = 2  # steps, before and after the coarse grid
OVERCORRECTION = 1.8  # constant pieces are stiffer than the film


@dataclass
class Film:
    """Equations diagonal z - (sum of bonds times z of the neighbours) = right; `bonds` None: all 1.
    A neighbour of known height has the index of no point.
    """

    neighbours: list[np.ndarray]
    diagonal: np.ndarray
    bonds: list[np.ndarray] | None = None

    def apply(self, heights: np.ndarray) -> np.ndarray:
        """Return the left-hand sides, in the precision of the heights."""
        with_known = np.append(heights, heights.dtype.type(0))
        sides = self.diagonal.astype(heights.dtype, copy=False) * heights
        for k, neighbour in enumerate(self.neighbours):
            pulls = with_known[neighbour]
            if self.bonds is not None:
                pulls *= self.bonds[k]
            sides -= pulls
        return sides

    def coarsened(self, parents: np.ndarray, count: int) -> "Film":
        """Return the equations of `count` aggregates; parents: the aggregate of each point."""
        with_known = np.append(parents, np.int32(count))
        neighbours = []
        bonds = []
        diagonal = np.bincount(parents, self.diagonal, count)
        for k, neighbour in enumerate(self.neighbours):
            beside = with_known[neighbour]
            pulls = np.float32(1) if self.bonds is None else self.bonds[k]
            inside = np.where(beside == parents, pulls, np.float32(0))
            diagonal -= np.bincount(parents, inside, count)
            across = np.where((beside != parents) & (beside < count), pulls, np.float32(0))
            bonds.append(np.bincount(parents, across, count).astype(np.float32))
            of_aggregates = np.full(count, count, np.int32)
            of_aggregates[parents[across > 0]] = beside[across > 0]
            neighbours.append(of_aggregates)
        return Film(neighbours, diagonal.astype(np.float32), bonds)

    def factors(self) -> Any:
        """Return the factors of the matrix, by SuperLU."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        points = np.arange(self.diagonal.size)
        rows = [points]
        columns = [points]
        values = [self.diagonal.astype(np.float64)]
        for k, neighbour in enumerate(self.neighbours):
            is_unknown = neighbour < points.size
            rows.append(points[is_unknown])
            columns.append(neighbour[is_unknown])
            pulls = np.ones(points.size) if self.bonds is None else self.bonds[k]
            values.append(-pulls[is_unknown])
        places = np.concatenate(rows), np.concatenate(columns)
        shape = (points.size, points.size)
        return splu(csc_array((np.concatenate(values), places), shape=shape))


@dataclass
class FilmLevel:
    """A level of the multigrid; `parents`: the aggregate of each point on the next one, None on the
    coarsest, which has `factors`; `weights`: DAMPING over the diagonal.
    """

    film: Film
    parents: np.ndarray | None = None
    factors: Any = None

    def __post_init__(self) -> None:
        self.weights = (DAMPING / self.film.diagonal).astype(np.float32)


def solve_film(film: Film, right: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the heights of points x, y in holes; MemoryError or ArithmeticError if that fails."""
    from scipy.sparse.linalg import LinearOperator, cg

    size = right.size
    if size <= DIRECT:
        return np.asarray(film.factors().solve(right))
    levels = _levels(film, x, y)
    del x, y

    def preconditioned(residual: np.ndarray) -> np.ndarray:
        largest = np.abs(residual).max() or 1.0
        return largest * _cycle(levels, 0, (residual.ravel() / largest).astype(np.float32))

    matrix = LinearOperator((size, size), lambda z: film.apply(z.ravel()), dtype=float)
    cycle = LinearOperator((size, size), preconditioned, dtype=float)
    heights: np.ndarray
    heights, steps = cg(matrix, right, rtol=TOLERANCE, atol=0.0, maxiter=STEPS, M=cycle)
    if steps:
        raise ArithmeticError(f"filling holes did not converge in {steps} steps")
    return heights


def _levels(film: Film, x: np.ndarray, y: np.ndarray) -> list[FilmLevel]:
    """Build the levels, finest first, to at most DIRECT points, of 2 x 2 grid points each."""
    levels = []
    while len(x) > DIRECT:
        x = x // 2
        y = y // 2
        width = int(y.max()) + 1
        places, parents = np.unique(x.astype(np.int64) * width + y, return_inverse=True)
        x = (places // width).astype(np.int32)
        y = (places % width).astype(np.int32)
        parents = parents.ravel().astype(np.int32)
        levels.append(FilmLevel(film, parents))
        film = film.coarsened(parents, len(places))
    levels.append(FilmLevel(film, factors=film.factors()))
    return levels


def _cycle(levels: list[FilmLevel], depth: int, residual: np.ndarray) -> np.ndarray:
    """Return an approximate solution of the equations of levels[depth] by one symmetric V-cycle."""
    level = levels[depth]
    film = level.film
    if level.parents is None:
        return np.asarray(level.factors.solve(residual.astype(np.float64)), np.float32)
    solution = level.weights * residual
    for _ in range(SMOOTHING - 1):
        solution += level.weights * (residual - film.apply(solution))
    rest = residual - film.apply(solution)
    coarse = np.bincount(level.parents, rest, len(levels[depth + 1].weights)).astype(np.float32)
    del rest
    correction = np.float32(OVERCORRECTION) * _cycle(levels, depth + 1, coarse)
    solution += correction[level.parents]
    for _ in range(SMOOTHING):
        solution += level.weights * (residual - film.apply(solution))
    return solution
