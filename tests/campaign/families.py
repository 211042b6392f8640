"""The families: each makes a random wall and its loads from a random number generator. Walls are in units of nothing."""

import zlib
from dataclasses import dataclass, field, replace

import numpy as np

from .shapes import (
    ODDS,
    PRIMES,
    choice,
    coordinates,
    distances,
    frequencies,
    grid,
    log_uniform,
    pixels,
    rough,
    square_pixels,
)
from .truth import Contact

FAMILIES = {}


@dataclass(frozen=True)
class Wall:
    """heights (peaks up); physical_sizes; loads: p* in the order of solving; E_star; surface: table [surface] of a scene that has
    these heights, where one does; units: whether the campaign may choose others."""

    heights: np.ndarray
    physical_sizes: tuple[float, float]
    loads: tuple[float, ...]
    E_star: float = 1.0
    surface: dict | None = None
    units: bool = True
    note: dict = field(default_factory=dict)


def family(function):
    FAMILIES[function.__name__] = function
    return function


def make(name, seed, index):
    """Wall number `index` of a family."""
    rng = np.random.default_rng([seed, index, zlib.crc32(name.encode())])
    wall = FAMILIES[name](rng)
    if wall.units and rng.random() < 0.5:
        heights, size, E_star = (log_uniform(rng, 1e-3, 1e3) for _ in range(3))
        wall = replace(wall, heights=wall.heights * heights, physical_sizes=tuple(size * s for s in wall.physical_sizes), E_star=E_star)
    return wall


def single(rng, z, sizes=None, low=1e-3, high=1.0, **others):
    """A wall with one load, log-uniform between low and high."""
    return Wall(z, tuple(sizes or square_pixels(z.shape)), (log_uniform(rng, low, high),), **others)


# -- roughness of every kind -------------------------------------------------------------------------------------------------------


@family
def self_affine(rng):
    return single(rng, rough(rng, grid(rng)))


@family
def self_affine_smooth(rng):
    n = grid(rng)
    low = rng.uniform(1, 3)
    return single(rng, rough(rng, n, modes=(low, max(1.5 * low, n[0] / log_uniform(rng, 6, 20)))))


@family
def roll_off(rng):
    return single(rng, rough(rng, grid(rng), roll_off=rng.uniform(2, 5)))


@family
def prime_grid(rng):
    n = choice(rng, PRIMES), choice(rng, PRIMES[:3])
    return single(rng, rough(rng, n if rng.random() < 0.5 else (n[0], n[0])))


@family
def odd_grid(rng):
    n = choice(rng, ODDS)
    return single(rng, rough(rng, (n, n if rng.random() < 0.5 else 64)))


@family
def long_cell(rng):
    n = choice(rng, ((512, 32), (32, 512), (640, 40), (40, 640), (1024, 64)))
    return single(rng, rough(rng, n))


@family
def thin_pixels(rng):
    n = grid(rng)
    ratio = choice(rng, (1 / 16, 16, 1 / 4, 4, 1.5))
    sizes = (1.0, n[1] / n[0] * ratio)
    return single(rng, rough(rng, n, sizes), sizes)


@family
def thin_pixels_noise(rng):
    n = grid(rng)
    return single(rng, rng.standard_normal(n), (1.0, n[1] / n[0] * choice(rng, (1 / 16, 16))))


@family
def anisotropic(rng):
    return single(rng, rough(rng, grid(rng), stretch=choice(rng, (1 / 16, 1 / 4, 4, 16))))


@family
def white_noise(rng):
    return single(rng, rng.standard_normal(grid(rng)), high=3.0)


@family
def two_scales(rng):
    n = grid(rng)
    z = rough(rng, n, modes=(1, 4)) + log_uniform(rng, 1e-3, 0.3) * rough(rng, n, modes=(n[0] / 8, n[0] / 3))
    return single(rng, z)


@family
def long_mode(rng):
    """One long wave and little roughness: a slow global error."""
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    k = choice(rng, ((1, 0), (0, 1), (1, 1)))
    z = np.cos(2 * np.pi * (k[0] * x + k[1] * y)) + log_uniform(rng, 1e-4, 0.1) * rough(rng, n)
    return single(rng, z, low=1e-4)


@family
def quantised(rng):
    return single(rng, np.round(rough(rng, grid(rng)) * choice(rng, (1, 2, 4, 16))))


@family
def offset(rng):
    return single(rng, rough(rng, grid(rng)) + rng.choice([-1, 1]) * log_uniform(rng, 1e2, 1e6))


@family
def heavy_tails(rng):
    n = grid(rng)
    z = rng.standard_t(choice(rng, (1.5, 2, 3)), n)
    k = frequencies(n, square_pixels(n))
    return single(rng, np.fft.ifft2(np.fft.fft2(z) * np.maximum(k, 1) ** -rng.uniform(0, 1.5)).real)


@family
def exponential(rng):
    return single(rng, np.exp(rng.uniform(0.3, 2) * rough(rng, grid(rng))), low=1e-4)


@family
def minus_exponential(rng):
    return single(rng, -np.exp(rng.uniform(0.3, 2) * rough(rng, grid(rng))), high=3.0)


@family
def plateaus(rng):
    z = rough(rng, grid(rng))
    return single(rng, np.minimum(z, np.quantile(z, rng.uniform(0.4, 0.95))))


@family
def honed(rng):
    n = grid(rng)
    x, y = coordinates(n, square_pixels(n))
    z = 0.2 * rough(rng, n)
    for slope in (1, -1):
        for _ in range(rng.integers(2, 6)):
            phase = (x + slope * choice(rng, (1, 2)) * y * n[0] / n[1] + rng.random()) % 1.0
            z = z - rng.uniform(0.5, 2) * np.exp(-(((phase - 0.5) * n[0] / rng.uniform(1, 4)) ** 2))
    return single(rng, z)


@family
def steps(rng):
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    z = choice(rng, (0.0, 0.05, 0.3)) * rough(rng, n)
    for _ in range(rng.integers(1, 6)):
        angle = rng.uniform(0, np.pi)
        z = z + rng.uniform(0.2, 1) * (np.cos(angle) * x + np.sin(angle) * y > rng.uniform(-0.4, 0.4))
    return single(rng, z)


@family
def telegraph(rng):
    n = grid(rng)
    z = (rough(rng, n, hurst=rng.uniform(0, 0.8)) > rng.uniform(-0.5, 1.5)).astype(float)
    return single(rng, z + choice(rng, (0.0, 1e-3, 0.05)) * rough(rng, n))


@family
def rough_large(rng):
    n = choice(rng, (256, 320, 243))
    return single(rng, rough(rng, (n, n)))


@family
def strip(rng):
    n = choice(rng, ((4, 1000), (1000, 4), (8, 512), (3, 729), (2, 1024)))
    return single(rng, rough(rng, n))


@family
def few_rows_noise(rng):
    return single(rng, rng.standard_normal(choice(rng, ((4, 1000), (1000, 4), (5, 500)))))


@family
def ridges(rng):
    """Nearly one-dimensional: high along one axis, a little rough along the other."""
    n = choice(rng, ((64, 64), (128, 128), (100, 100), (256, 32), (32, 256), (512, 16)))
    axis = int(rng.integers(2))
    line = rough(rng, (n[axis], 1), (1.0, 1.0), modes=(1, n[axis] / rng.uniform(2, 8)))
    z = (line if axis == 0 else line.T) + log_uniform(rng, 1e-5, 0.1) * rough(rng, n)
    return single(rng, z)


@family
def tiny(rng):
    """Grids of hardly any points, also along one axis only."""
    n = choice(rng, ((2, 2), (3, 3), (1, 64), (97, 1), (2, 31), (5, 4), (8, 8), (16, 16), (1, 1000)))
    return single(rng, rng.standard_normal(n) if rng.random() < 0.5 else np.exp(rng.standard_normal(n)), low=1e-4, high=3)


# -- spikes and pits ---------------------------------------------------------------------------------------------------------------


@family
def spike(rng):
    n = grid(rng)
    z = log_uniform(rng, 1e-3, 1) * rough(rng, n)
    z[tuple(rng.integers(n))] += log_uniform(rng, 1, 100)
    return single(rng, z, low=1e-5)


@family
def spikes(rng):
    n = grid(rng)
    z = log_uniform(rng, 1e-3, 1) * rough(rng, n)
    for _ in range(rng.integers(2, 40)):
        z[tuple(rng.integers(n))] += log_uniform(rng, 0.3, 10)
    return single(rng, z, low=1e-5)


@family
def dust(rng):
    """Hemispheres of a few points on a rough wall."""
    n = grid(rng)
    sizes = square_pixels(n)
    z = log_uniform(rng, 0.01, 1) * rough(rng, n)
    for dx, dy in distances(rng, n, sizes, int(rng.integers(1, 30))):
        radius = log_uniform(rng, 1.5, 8) / n[0]
        z = z + log_uniform(rng, 0.3, 5) * np.sqrt(np.maximum(1 - (dx**2 + dy**2) / radius**2, 0))
    return single(rng, z, low=1e-4)


@family
def pits(rng):
    n = grid(rng)
    z = choice(rng, (0.0, 0.01, 0.1)) * rough(rng, n)
    for _ in range(rng.integers(1, 20)):
        z[tuple(rng.integers(n))] -= log_uniform(rng, 0.1, 10)
    return single(rng, z, low=1e-2, high=3)


# -- near full contact -------------------------------------------------------------------------------------------------------------


@family
def near_full(rng):
    return single(rng, rough(rng, grid(rng)), low=0.4, high=20)


@family
def near_full_closing(rng):
    """The last open points, which single loads of a wide range miss."""
    n = grid(rng)
    z = rough(rng, n)
    return Wall(z, square_pixels(n), (_load_of_area(z, 1 - log_uniform(rng, 2 / z.size, 0.05)),))


@family
def near_full_skewed(rng):
    z = rough(rng, grid(rng))
    s = choice(rng, (-1, 1)) * rng.uniform(0.1, 0.8)
    return single(rng, z + s * z * z, low=0.4, high=20)


@family
def high_pressure(rng):
    z = rough(rng, grid(rng)) if rng.random() < 0.5 else -np.exp(rng.uniform(0.5, 2.5) * rough(rng, grid(rng)))
    return single(rng, z, low=1, high=100)


@family
def smooth_near_full(rng):
    """Waves of one length (or nearly), well resolved: lam_s/a of 4 to 64."""
    per_wave = choice(rng, (4, 8, 12, 16, 32))
    waves = choice(rng, [k for k in (1, 2, 3, 4, 5, 8) if 32 <= k * per_wave <= 160])
    n = waves * per_wave
    z = rough(rng, (n, n), modes=(waves, waves * choice(rng, (1, 1, 1.5, 2))))
    return Wall(z, (1.0, 1.0), (log_uniform(rng, 0.3, 1.2),))


@family
def smooth_near_full_large(rng):
    per_wave, waves = choice(rng, ((32, 8), (64, 4), (64, 5), (128, 2), (32, 10), (64, 8)))
    n = waves * per_wave
    z = rough(rng, (n, n), hurst=0.93, modes=(waves, waves * choice(rng, (1, 1, 2))))
    return Wall(z, (1.0, 1.0), (log_uniform(rng, 0.3, 1.2),))


@family
def smooth_scene(rng):
    """As smooth_near_full, with the heights of the program's own scenes; the first is a known hard one."""
    seed = int(choice(rng, (421, *range(1, 60))))
    surface = {"kind": "self-affine", "hurst": 0.93, "L_over_lam_l": 4, "lam_l_over_lam_s": 1, "lam_s_over_a": choice(rng, (8, 16, 32)),
               "seed": seed}
    p_star = 0.836 if rng.random() < 0.2 else log_uniform(rng, 0.4, 1.1)
    return scene_wall(surface, (p_star,))


# -- punches and indenters ---------------------------------------------------------------------------------------------------------


@family
def punch_square(rng):
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    a, b = rng.uniform(0.1, 0.45, 2)
    return single(rng, 1.0 * ((np.abs(x) < a) & (np.abs(y) < b)), pixels(rng, n), low=1e-4)


@family
def punch_round(rng):
    n = grid(rng)
    x, y = coordinates(n, square_pixels(n))
    return single(rng, 1.0 * (np.hypot(x, y) < rng.uniform(0.1, 0.45) * min(1, n[1] / n[0])), low=1e-4)


@family
def punches(rng):
    """Several, of their own heights, perhaps tilted or rough."""
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    z = np.zeros(n)
    for dx, dy in distances(rng, n, (1, 1), int(rng.integers(2, 12))):
        inside = (dx < rng.uniform(0.03, 0.15)) & (dy < rng.uniform(0.03, 0.15))
        z = np.where(inside, 1 + log_uniform(rng, 1e-3, 0.3), z)
    z = z + choice(rng, (0, 1e-3, 0.05)) * (x * (z > 0) + 0 * y) + choice(rng, (0, 1e-3, 0.02)) * rough(rng, n)
    return single(rng, z, low=1e-4)


def _indenter(shape):
    def make_wall(rng):
        n = grid(rng)
        sizes = pixels(rng, n)
        x, y = coordinates(n, sizes)
        shift = rng.random(2) / n if rng.random() < 0.5 else (0, 0)
        return single(rng, shape(x + shift[0], y + shift[1]), sizes, low=1e-4)

    return make_wall


for _name, _shape in {"sphere": lambda x, y: -(x**2 + y**2), "cone": lambda x, y: -np.hypot(x, y),
                      "wedge": lambda x, y: -np.abs(x) + 0 * y, "pyramid": lambda x, y: -np.maximum(np.abs(x), np.abs(y)),
                      "cylinder": lambda x, y: -(y**2) + 0 * x, "ellipsoid": lambda x, y: -(x**2 + 30 * y**2)}.items():
    FAMILIES[_name] = _indenter(_shape)


@family
def rough_sphere(rng):
    n = grid(rng)
    x, y = coordinates(n, square_pixels(n))
    return single(rng, -(x**2 + y**2) + log_uniform(rng, 1e-4, 0.03) * rough(rng, n), low=1e-4)


# -- order -------------------------------------------------------------------------------------------------------------------------


@family
def sines(rng):
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    kx, ky = int(rng.integers(0, 4)), int(rng.integers(1, 4))
    z = np.cos(2 * np.pi * kx * x) * np.cos(2 * np.pi * ky * y) if rng.random() < 0.5 else (
        np.cos(2 * np.pi * kx * x) + rng.uniform(0.1, 1) * np.cos(2 * np.pi * ky * y))
    return single(rng, z + 0 * x * y)


WAVES = ((100, 5), (128, 4), (96, 6), (64, 4), (120, 8), (72, 6), (160, 10), (128, 8), (81, 9), (105, 5))
HARD_WAVES = ((100, 5, 0.02432), (100, 5, 0.0708), (128, 4, 0.1155), (128, 4, 0.2061))


def _wave(n, k):
    c = np.cos(2 * np.pi * ((k * np.arange(n)) % n) / n)
    return np.outer(c, c)


@family
def wave(rng):
    """cos x cos y with k x k periods, perfectly ordered."""
    n, k = choice(rng, WAVES)
    return single(rng, _wave(n, k), pixels(rng, (n, n)), low=3e-3, high=0.6)


LATTICES = ((72, 12), (128, 16), (96, 12), (96, 16), (144, 12), (64, 8), (100, 10), (120, 24), (120, 20))


def _lattice(n, d):
    x = (np.arange(n) % d - d // 2) / d
    return -(x[:, None] ** 2 + x[None, :] ** 2)


@family
def lattice(rng):
    """Paraboloids, all equal."""
    n, d = choice(rng, LATTICES)
    return single(rng, _lattice(n, d), pixels(rng, (n, n)), low=3e-3, high=0.6)


@family
def lattice_noise(rng):
    z = _lattice(*choice(rng, LATTICES))
    return single(rng, z + log_uniform(rng, 1e-8, 0.03) * rng.standard_normal(z.shape), low=1e-3, high=0.6)


@family
def wave_noise(rng):
    z = _wave(*choice(rng, WAVES))
    return single(rng, z + log_uniform(rng, 1e-8, 0.03) * rough(rng, z.shape), low=1e-3, high=0.6)


@family
def checkerboard(rng):
    n, d = choice(rng, ((64, 8), (96, 12), (128, 16), (120, 10), (96, 4)))
    i = np.arange(n) // d % 2
    z = 1.0 * (i[:, None] ^ i[None, :])
    return single(rng, z + choice(rng, (0, 1e-4, 1e-2)) * rough(rng, (n, n)))


@family
def replicas(rng):
    """A small rough cell many times over: every event happens everywhere at once."""
    m, copies = choice(rng, ((16, 4), (16, 6), (20, 5), (32, 4), (12, 8)))
    return single(rng, np.tile(rough(rng, (m, m), modes=(1, m / 2.5)), (copies, copies)))


@family
def known(rng):
    """What is known to be hard."""
    if rng.random() < 0.3:
        return scene_wall({"kind": "self-affine", "hurst": 0.93, "L_over_lam_l": 4, "lam_l_over_lam_s": 1, "lam_s_over_a": 32,
                           "seed": 421}, (0.836 * np.exp(rng.uniform(-0.01, 0.01)),))
    n, k, p_star = choice(rng, HARD_WAVES)
    return Wall(_wave(n, k), (1.0, 1.0), (p_star * float(np.exp(rng.choice([0, 0.01]) * rng.uniform(-1, 1))),))


# -- few points, and loads where something happens ---------------------------------------------------------------------------------


def _load_of_area(z, a_r, sizes=None):
    """The p* that gives about this share of points in contact, by bisection."""
    contact = Contact(z, sizes or square_pixels(z.shape))
    low, high = 1e-7, 50.0
    for _ in range(18):
        middle = np.sqrt(low * high)
        if contact.solve(middle).contact < a_r * z.size:
            low = middle
        else:
            high = middle
    return float(np.sqrt(low * high))


def _change_of_sides(rng, z, sizes, p_star):
    """A load near p* at which the number of points changes, off by a random small share."""
    contact = Contact(z, sizes)
    low, high = p_star, p_star * 1.2
    n_low, n_high = contact.solve(low).contact, contact.solve(high).contact
    if n_low == n_high:
        return p_star
    for _ in range(int(rng.integers(8, 22))):
        middle = 0.5 * (low + high)
        n = contact.solve(middle).contact
        low, high = (middle, high) if abs(n - n_low) < abs(n - n_high) else (low, middle)
    return float(rng.choice([low, high]))


@family
def few_points(rng):
    """Few contact points and a load near a change of sides."""
    n = choice(rng, ((32, 32), (48, 48), (64, 64), (37, 37), (32, 128), (80, 80)))
    z = rough(rng, n) if rng.random() < 0.7 else rng.standard_normal(n)
    p_star = log_uniform(rng, 3, 60) / z.size / 2
    sizes = square_pixels(n)
    return Wall(z, sizes, (_change_of_sides(rng, z, sizes, p_star),))


@family
def few_points_smooth(rng):
    n = choice(rng, ((48, 48), (64, 64), (100, 100)))
    z = rough(rng, n, modes=(1, n[0] / rng.uniform(6, 16)))
    return Wall(z, (1.0, 1.0), (_change_of_sides(rng, z, (1.0, 1.0), log_uniform(rng, 5, 100) / z.size / 3),))


@family
def few_asperities(rng):
    """Some smooth bumps of their own heights, and a load near a change of sides."""
    n = choice(rng, ((64, 64), (100, 100), (81, 81), (128, 64)))
    sizes = square_pixels(n)
    z = np.zeros(n)
    for dx, dy in distances(rng, n, sizes, int(rng.integers(2, 20))):
        width = log_uniform(rng, 0.03, 0.2)
        z = np.maximum(z, rng.uniform(0.5, 1) * np.exp(-(dx**2 + dy**2) / (2 * width**2)))
    return Wall(z, sizes, (_change_of_sides(rng, z, sizes, log_uniform(rng, 5, 200) / z.size / 2),))


@family
def light(rng):
    return single(rng, rough(rng, grid(rng)), low=1e-5, high=3e-3)


@family
def change_of_sides(rng):
    n = choice(rng, ((64, 64), (96, 96), (72, 72)))
    z = choice(rng, (rough(rng, n), _wave(96, 6), _lattice(72, 12)))
    return Wall(z, square_pixels(z.shape), (_change_of_sides(rng, z, square_pixels(z.shape), log_uniform(rng, 5e-3, 0.7)),))


@family
def extreme_units(rng):
    wall = choice(rng, (self_affine, sphere_like, wave, near_full))(rng)
    heights, E_star = (10.0 ** rng.uniform(-45, 45) for _ in range(2))
    sizes = tuple(s * 10.0 ** rng.uniform(-45, 45) for s in (1.0,)) * 2
    return Wall(wall.heights * heights, (sizes[0] * wall.physical_sizes[0], sizes[0] * wall.physical_sizes[1]), wall.loads, E_star,
                units=False)


def sphere_like(rng):
    return FAMILIES["sphere"](rng)


# -- scenes of the program itself, for what needs their spectrum -------------------------------------------------------------------


def scene_wall(surface, loads):
    """A Wall with the heights that the program makes of a table [surface]."""
    from hpc_gfmd.parallel.comm import SerialComm
    from hpc_gfmd.scene import Scene
    from hpc_gfmd.surface import build_surface

    spec = Scene.from_dict({"surface": surface, "load": {"p_star": 1.0}}).surface
    made = build_surface(spec, SerialComm(), np.dtype(np.float64))
    heights = -np.asarray(made.h) * made.height_unit
    return Wall(heights, tuple(spec.physical_sizes), tuple(loads), 1.0, surface, units=False)


def scene_surface(rng, lam_s_over_a=(2, 8)):
    """A [surface] table of 32 to 160 points along x."""
    n_x = choice(rng, (64, 72, 96, 100, 128, 160, 97))
    n_y = n_x if rng.random() < 0.7 else choice(rng, (32, 64, 128))
    L_over_lam_l, lam_s_over_a = rng.uniform(1, 3), rng.uniform(*lam_s_over_a)
    return {"kind": "self-affine", "hurst": round(rng.uniform(0, 1), 2), "L_over_lam_l": L_over_lam_l,
            "lam_l_over_lam_s": n_x / (L_over_lam_l * lam_s_over_a), "lam_s_over_a": lam_s_over_a,
            "seed": int(rng.integers(2**31)), "physical_sizes": [1.0, n_y / n_x]}


@family
def scene(rng):
    return scene_wall(scene_surface(rng), (log_uniform(rng, 1e-3, 1.5),))


@family
def few_points_scene(rng):
    wall = scene_wall(scene_surface(rng, lam_s_over_a=(4, 16)), (1.0,))
    p_star = log_uniform(rng, 5, 300) / wall.heights.size / 2
    return replace(wall, loads=(_change_of_sides(rng, wall.heights, wall.physical_sizes, p_star),))
