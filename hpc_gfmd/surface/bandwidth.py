"""How much of the slope of a map is in its shortest waves."""

import numpy as np

from ..util.quantities import prefixed

POINTS = 4  # of a wave that counts as short
LARGEST = 1024  # points along an axis that are looked at, in the middle of the map


def bandwidth_line(z: np.ndarray, sizes: tuple[float, ...], unit: str) -> str:
    """Return a line on the share of g_rms^2 at the shortest waves and what it does to a_r, which at
    light loads goes as 1/g_rms. z: heights (n_x, n_y), periodic or not.
    """
    spacings = np.divide(sizes, z.shape)
    starts = [max(n - LARGEST, 0) // 2 for n in z.shape]
    middle = z[tuple(slice(start, start + LARGEST) for start in starts)]
    window = np.multiply.outer(*(np.hanning(n + 2)[1:-1] for n in middle.shape))
    power = np.abs(np.fft.fft2((middle - middle.mean()) * window)) ** 2
    q_x, q_y = (np.fft.fftfreq(n, a) for n, a in zip(middle.shape, spacings))
    squared = q_x[:, None] ** 2 + q_y**2
    slopes = squared * power
    if not slopes.any():
        return ""
    shortest = POINTS * max(spacings)
    share = float(slopes[squared > 1 / shortest**2].sum() / slopes.sum())
    scale, name = prefixed([shortest], unit)
    text = (
        f"waves shorter than {shortest / scale:.3g} {name}".strip()
        + f" ({POINTS} points) have {100 * share:.2g} % of g_rms^2"
    )
    if share < 0.01:
        return text
    return (
        f"{text}: without them a_r at light loads would be {(1 - share) ** -0.5:.2f} times as"
        " large, and it is smaller by those that the instrument does not see"
    )
