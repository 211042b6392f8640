"""Building blocks of the walls of the campaign: grids, random fields and loads."""

import numpy as np

# Few grids, because each must be planned. Two thirds have smooth even sizes, as users choose them.
SQUARES = (32, 48, 64, 72, 80, 96, 100, 108, 120, 128, 144, 160)
PRIMES = (37, 53, 61, 79, 97, 101, 127, 149)
ODDS = (33, 45, 63, 75, 81, 99, 105, 125, 135)
RECTANGLES = ((32, 128), (128, 64), (96, 144), (150, 60), (64, 100), (40, 160), (120, 90))


def log_uniform(rng, low, high):
    """Return a random number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def choice(rng, items):
    """Return a random item."""
    return items[int(rng.integers(len(items)))]


def grid(rng):
    """Return a random (n_x, n_y), square or not, with 32 to 160 points along an axis."""
    if rng.random() < 0.25:
        return choice(rng, RECTANGLES)
    n = choice(rng, SQUARES)
    return n, n


def square_pixels(n):
    """Return the size of a cell with n_x x n_y square pixels."""
    return 1.0, n[1] / n[0]


def pixels(rng, n):
    """Return a random size of a cell, mostly with square pixels, otherwise up to 1:16."""
    ratio = choice(rng, (1 / 16, 1 / 4, 2, 4, 16)) if rng.random() < 0.25 else 1
    return 1.0, n[1] / n[0] * ratio


def frequencies(n, sizes):
    """Return |q| L_x / 2 pi of all modes."""
    return np.hypot(
        (np.fft.fftfreq(n[0]) * n[0])[:, None], np.fft.fftfreq(n[1]) * n[1] * sizes[0] / sizes[1]
    )


def coordinates(n, sizes):
    """Return x (n_x, 1) and y (1, n_y) about the centre of the cell."""
    return [
        (((np.arange(m) - m // 2) / m) * size).reshape(shape)
        for m, size, shape in zip(n, sizes, ((-1, 1), (1, -1)))
    ]


def rough(rng, n, sizes=None, hurst=None, modes=None, roll_off=1.0, stretch=1.0):
    """Return self-affine heights with rms 1.

    modes: lowest and highest |q| L_x / 2 pi, random by default, like the Hurst exponent. The
    spectrum is flat below roll_off times the lowest |q|. stretch: wavelengths along y over those
    along x.
    """
    sizes = sizes or square_pixels(n)
    hurst = rng.uniform(0, 1) if hurst is None else hurst
    k = frequencies(n, (sizes[0], sizes[1] / stretch))
    highest = n[0] * min(1.0, sizes[1] / sizes[0] * n[0] / n[1]) / 2
    if modes is None:
        low = rng.uniform(1, 4)
        modes = low, max(low * 1.5, n[0] / rng.uniform(2, 8))
    low, high = modes
    inside = (k >= low) & (k <= max(high, low)) & (k <= 1.5 * highest)
    if not inside.any():
        inside = (k > 0) & (k <= np.partition(k, 8, axis=None)[8])
    amplitude = np.where(inside, np.maximum(k, low * roll_off) ** (-1 - hurst), 0)
    z = np.fft.ifft2(np.fft.fft2(rng.standard_normal(n)) * amplitude).real
    return z / z.std()


def distances(rng, n, sizes, count):
    """Yield the distances (along x, along y) of all points from each of `count` random places.

    They are the shortest in the periodic cell.
    """
    x = np.arange(n[0]) * sizes[0] / n[0]
    y = np.arange(n[1]) * sizes[1] / n[1]
    for _ in range(count):
        dx = np.abs(x - rng.random() * sizes[0])
        dy = np.abs(y - rng.random() * sizes[1])
        yield np.minimum(dx, sizes[0] - dx)[:, None], np.minimum(dy, sizes[1] - dy)[None, :]
