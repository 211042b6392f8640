"""Missing heights, filled harmonically.

Each is the mean of its four neighbours, so that holes are closed as by a soap film. The equations
are solved by conjugate gradients, preconditioned by multigrid: on each coarser grid by those of the
blocks of 2 x 2 points that are missing altogether, until none is.
"""

from collections.abc import Iterator

import numpy as np

from ..util.errors import SceneError
from .topography import Topography

NEIGHBOURS = ((-1, 0), (1, 0), (0, -1), (0, 1))
TOLERANCE = 1e-13  # of the residual, relative to the right-hand side
STEPS = 400
DAMPING = 0.8  # of Jacobi's smoothing steps: the matrix is that of Laplace
SMOOTHING = 2  # steps, before and after the coarse grid


def filled(topography: Topography, how: str) -> Topography:
    """Return a map without missing heights, by "harmonic"; "none" refuses them with SceneError."""
    z = topography.heights()
    missing = np.isnan(z)
    count = int(np.count_nonzero(missing))
    if count == 0:
        return topography
    if how == "none" or count == z.size:
        i, j = np.unravel_index(missing.argmax(), z.shape)
        raise SceneError(
            f"surface.path: found nan at ({i}, {j}) in {topography.path}, {count} points"
            ' without a height, allowed: finite heights, or fill = "harmonic" where some are known'
        )
    z = z.copy()
    z[missing] = 0.0
    try:
        z[missing] = _film(z, missing)
    except MemoryError:
        raise SceneError(
            f"surface.fill: not enough memory to fill {count} points of {topography.path}, allowed:"
            " smaller holes, surface.crop, or more memory"
        ) from None
    line = f"{count} points ({100 * count / z.size:.2g} %) filled"
    return topography.of_heights(z, line, filled=count)


class Film:
    """The film over the missing points of a grid: 4 z - (sum of z of missing neighbours).

    Beyond an edge of the grid a point is its own neighbour. Everything is held by missing point,
    and in single precision.
    """

    def __init__(self, missing: np.ndarray) -> None:
        x, y = _places(missing)
        self.size = x.size
        number = _numbers(missing)
        points = np.arange(x.size, dtype=np.int32)
        self.diagonal = np.full(x.size, 4, np.float32)
        self.neighbours = []  # index of each of the four, that of no point if it is known
        for beside in _neighbours(x, y, missing.shape):
            neighbour = number[beside]
            is_itself = neighbour == points
            self.diagonal -= is_itself
            neighbour[is_itself] = x.size
            self.neighbours.append(neighbour)
        self.weights = np.float32(DAMPING) / self.diagonal
        whole = np.pad(missing, [(0, n % 2) for n in missing.shape], constant_values=True)
        rows = whole[::2] & whole[1::2]
        self.blocks = rows[:, ::2] & rows[:, 1::2]  # that are missing altogether
        self.parents = _numbers(self.blocks)[x // 2, y // 2]

    def apply(self, heights: np.ndarray) -> np.ndarray:
        """Return the left-hand sides, in the precision of the heights."""
        with_known = np.append(heights, heights.dtype.type(0))
        sides = self.diagonal.astype(heights.dtype, copy=False) * heights
        for neighbour in self.neighbours:
            sides -= with_known[neighbour]
        return sides


def _places(missing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.nonzero(missing)
    return x.astype(np.int32), y.astype(np.int32)


def _numbers(missing: np.ndarray) -> np.ndarray:
    """Return the number of each point among the missing ones; known ones have the next number."""
    count = np.count_nonzero(missing)
    number = np.full(missing.shape, count, np.int32)
    number[missing] = np.arange(count, dtype=np.int32)
    return number


def _neighbours(
    x: np.ndarray, y: np.ndarray, shape: tuple[int, ...]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the places of the four neighbours of points; beyond an edge it is the point itself."""
    for dx, dy in NEIGHBOURS:
        yield np.clip(x + dx, 0, shape[0] - 1), np.clip(y + dy, 0, shape[1] - 1)


def _film(z: np.ndarray, missing: np.ndarray) -> np.ndarray:
    """Return the heights of missing points, each the mean of its four neighbours; z is 0 there.

    Raises ArithmeticError without convergence.
    """
    from scipy.sparse.linalg import LinearOperator, cg

    right = np.zeros(np.count_nonzero(missing))
    for beside in _neighbours(*_places(missing), z.shape):
        right += z[beside]
    films = [Film(missing)]
    while films[-1].blocks.any():
        films.append(Film(films[-1].blocks))

    def preconditioned(residual: np.ndarray) -> np.ndarray:
        largest = np.abs(residual).max() or 1.0
        return largest * _cycle(films, (residual.ravel() / largest).astype(np.float32))

    shape = (right.size, right.size)
    matrix = LinearOperator(shape, lambda heights: films[0].apply(heights.ravel()), dtype=float)
    cycle = LinearOperator(shape, preconditioned, dtype=float)
    heights: np.ndarray
    heights, steps = cg(matrix, right, rtol=TOLERANCE, atol=0.0, maxiter=STEPS, M=cycle)
    if steps:
        raise ArithmeticError(f"filling holes did not converge in {steps} steps")
    return heights


def _cycle(films: list[Film], residual: np.ndarray) -> np.ndarray:
    """Return an approximate solution on the finest of some grids by one symmetric V-cycle."""
    film, *coarser = films
    solution = film.weights * residual
    for _ in range(SMOOTHING - 1):
        solution += film.weights * (residual - film.apply(solution))
    if coarser:
        rest = residual - film.apply(solution)
        of_blocks = np.bincount(film.parents, rest, coarser[0].size + 1)[:-1]
        correction = _cycle(coarser, of_blocks.astype(np.float32))
        solution += np.append(correction, np.float32(0))[film.parents]
    for _ in range(SMOOTHING):
        solution += film.weights * (residual - film.apply(solution))
    return solution
