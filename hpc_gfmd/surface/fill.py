"""Missing heights, filled harmonically.

Each is the mean of its four neighbours, so that holes are closed as by a soap film. The equations
are solved by conjugate gradients, preconditioned by multigrid: on each coarser grid by those of the
blocks of 2 x 2 points that are missing altogether, until none is. The map, in double precision, is
filled in place; beside it are, in single precision, a grid and two numbers per missing point.
"""

import numpy as np

from ..kernels.film import correct, gather, move, smooth, turn
from ..util.errors import SceneError
from .heights import ROWS
from .topography import Topography

COPIES = 2.0  # of a map that are held at once while it is filled,
OF_MISSING = 1.2  # and more by the share of its points that are missing
OF_RUNS = 1.4  # and by that of runs of missing points along y
COUNTED = 1.2  # copies where none is missing
TOLERANCE = 4e-15  # of what equations lack, rms, relative to the largest right-hand side
STEPS = 400


def filled(topography: Topography, how: str) -> Topography:
    """Return a map without missing heights, by "harmonic", which changes those of the topography;
    "none" refuses missing ones with SceneError.
    """
    z = np.ascontiguousarray(topography.heights())
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
    z[missing] = 0.0
    try:
        film = Film(missing)
        del missing
        _fill(z, film)
    except MemoryError:
        raise SceneError(
            f"surface.fill: not enough memory to fill {count} points of {topography.path}, allowed:"
            " smaller holes, surface.crop, or more memory"
        ) from None
    line = f"{count} points ({100 * count / z.size:.2g} %) filled"
    return topography.of_heights(z, line, filled=count)


def copies_of_filling(topography: Topography) -> float:
    """Return how many copies of a map filling its holes holds at once; reads the map by rows."""
    n_x, n_y = topography.n
    missing = 0
    runs = 0
    for start in range(0, n_x, ROWS):
        holes = np.isnan(topography.rows(start, min(start + ROWS, n_x)))
        missing += int(np.count_nonzero(holes))
        runs += int(np.count_nonzero(holes[:, 0]))
        runs += int(np.count_nonzero(holes[:, 1:] > holes[:, :-1]))
    if missing == 0:
        return COUNTED
    return COPIES + (OF_MISSING * missing + OF_RUNS * runs) / (n_x * n_y)


class Film:
    """The film over the missing points of a grid: 4 z - (sum of z of missing neighbours) = right.

    See `kernels.film`.
    """

    def __init__(self, missing: np.ndarray) -> None:
        width = missing.shape[1] + 1
        bordered = np.pad(missing, ((0, 0), (0, 1))).ravel()
        begin, end = np.flatnonzero(np.diff(bordered, prepend=False)).reshape(-1, 2).T
        self.runs = np.empty((begin.size, 3), np.int32)
        np.floor_divide(begin, width, out=self.runs[:, 0], casting="unsafe")
        np.remainder(begin, width, out=self.runs[:, 1], casting="unsafe")
        np.remainder(end, width, out=self.runs[:, 2], casting="unsafe")
        del bordered, begin, end
        self.right = np.empty(np.count_nonzero(missing), np.float32)
        self.heights = np.zeros(missing.shape, np.float32)
        if self.right.size:
            whole = np.pad(missing, [(0, n % 2) for n in missing.shape], constant_values=True)
            rows = whole[::2] & whole[1::2]
            self.of_blocks = Film(rows[:, ::2] & rows[:, 1::2])  # that are missing altogether

    def lay(self) -> float:
        """Find the heights, nearly, by a symmetric V-cycle; return their product with `right`."""
        if not self.right.size:
            return 0.0
        blocks = self.of_blocks
        self.heights.fill(0)
        blocks.heights.fill(0)
        smooth(self.heights, self.right, self.runs, blocks.heights)
        gather(blocks.heights, blocks.runs, blocks.right)
        blocks.lay()
        product: float = correct(self.heights, self.right, self.runs, blocks.heights)
        return product


def _fill(z: np.ndarray, film: Film) -> None:
    """Fill the missing heights of a map, which are 0; ArithmeticError without convergence."""
    direction = np.zeros_like(film.right)
    scale = move(z, film.runs, direction, 0.0, 1.0, film.right)
    if scale == 0:
        return
    move(z, film.runs, direction, 0.0, scale, film.right)
    product = 1.0
    for _ in range(STEPS):
        before, product = product, film.lay()
        curvature = turn(direction, product / before, film.heights, film.runs)
        move(z, film.runs, direction, scale * product / curvature, scale, film.right)
        if np.linalg.norm(film.right) <= TOLERANCE * film.right.size**0.5:
            return
    raise ArithmeticError(f"filling holes did not converge in {STEPS} steps")
