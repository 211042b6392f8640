"""Two scans with different points, sizes and positions are added on the points of the finer one, in
the window that both cover."""

from math import gcd
from pathlib import Path

import numpy as np
import pytest
import tomli_w
from contacts import random_heights
from refusal import refused
from scipy.interpolate import make_interp_spline

import hpc_gfmd
from hpc_gfmd.scene import File, Scene
from hpc_gfmd.surface.topography import open_topography

NOT_MIRRORED = {"mirrored": "none"}


def two_random_maps(*shapes):
    return [random_heights(shape, seed=k) for k, shape in enumerate(shapes, 1)]


def combine(first, a, second, b, **keys):
    """combine_surfaces of two arrays with free edges and point distances a and b."""
    scans = [
        hpc_gfmd.prepare_surface(
            z, physical_sizes=tuple(np.multiply(z.shape, spacings)), boundary="free"
        )
        for z, spacings in ((first, a), (second, b))
    ]
    return hpc_gfmd.combine_surfaces(*scans, **keys)


RATIOS = [(p, q) for p in range(1, 13) for q in range(1, 13) if gcd(p, q) == 1]


def test_all_ratios_of_spacings():
    """Points of spacings p/q and 1 of the line z = x/4 + y/2 and of one period of a wave, which
    natural and periodic splines give back: whichever points coincide, no point is another's."""
    for p, q in RATIOS:
        a = p / q
        n = (3 * q + 1, 5 * q + 2)
        m = (3 * p + 1, 5 * p - 1)  # of spacing 1: the first ones end together along x
        lines = [
            np.add.outer(spacing * np.arange(n_x) / 4, spacing * np.arange(n_y) / 2)
            for spacing, (n_x, n_y) in ((a, n), (1.0, m))
        ]
        fine = min(a, 1.0)
        for shift in ((0, 0), (fine / 2, -a), (-1.0, 1.0)):
            surface = combine(lines[0], (a, a), lines[1], (1, 1), shift=shift, **NOT_MIRRORED)
            rise = np.diff(surface.heights, axis=0), np.diff(surface.heights, axis=1)
            assert np.allclose(rise[0], 2 * fine / 4, rtol=0, atol=1e-12), (p, q, shift)
            assert np.allclose(rise[1], 2 * fine / 2, rtol=0, atol=1e-12), (p, q, shift)
            for axis, (first, second) in enumerate(zip(n, m)):  # what both cover
                begin = max(0.0, shift[axis])
                end = min(a * (first - 1), second - 1 + shift[axis])
                covered = (end - begin) / fine
                assert covered - 2 < surface.heights.shape[axis] - 1 <= covered + 1e-9


def test_periodic_scans():
    """The window is the whole cell, and splines are periodic."""
    first, second = two_random_maps((24, 20), (15, 16))
    scans = [hpc_gfmd.prepare_surface(z, boundary="periodic") for z in (first, second)]
    surface = hpc_gfmd.combine_surfaces(*scans, shift=(-0.2, 1.3), **NOT_MIRRORED)
    expected = second
    for axis, shift in ((0, -0.2), (1, 1.3)):
        n = second.shape[axis]
        cell = np.take(expected, np.arange(n + 1), axis=axis, mode="wrap")
        spline = make_interp_spline(np.arange(n + 1) / n, cell, axis=axis, bc_type="periodic")
        points = first.shape[axis]
        expected = spline((np.arange(points) / points - shift) % 1)
    assert np.allclose(surface.heights, first + expected, rtol=0, atol=1e-13)
    assert surface.free == (False, False)
    assert surface.sizes == (1.0, 1.0)
    far = hpc_gfmd.combine_surfaces(*scans, shift=(2.0**60 - 256.0, -(2.0**40) + 0.25))
    near = hpc_gfmd.combine_surfaces(*scans, shift=(0.0, 0.25))
    assert np.array_equal(far.heights, near.heights)


@pytest.mark.parametrize(
    ("i", "j"), [(0, 0), (3, -2), (-5, 7), (0, 10)], ids=lambda shift: str(shift)
)
def test_shift(i, j):
    """Shifts by whole points need no interpolation in the window that both scans cover."""
    first_map, second_map = two_random_maps((20, 16), (18, 12))
    surface = combine(
        first_map, (0.5, 0.5), second_map, (0.5, 0.5), shift=(i / 2, j / 2), **NOT_MIRRORED
    )
    x = slice(max(i, 0), min(20, 18 + i))
    y = slice(max(j, 0), min(16, 12 + j))
    moved = second_map[x.start - i : x.stop - i, y.start - j : y.stop - j]
    assert np.array_equal(surface.heights, first_map[x, y] + moved)


@pytest.mark.parametrize("boundary", ["mirror", ["free", "mirror"], ["mirror", "periodic"]])
def test_scans_of_pieces_are_added_where_they_overlap(boundary, tmp_path):
    """A piece of a larger surface does not go on with its other end: only the sum is mirrored."""
    lower, upper = two_random_maps((12, 10), (12, 10))
    np.save("lower.npy", lower)
    np.save("upper.npy", upper)
    surface = hpc_gfmd.combine_surfaces(
        "lower.npy",
        "upper.npy",
        shift=(3, 2),
        physical_sizes=(12, 10),
        boundary=boundary,
        **NOT_MIRRORED,
    )
    if "periodic" in boundary:
        total = lower[3:] + np.roll(upper, 2, axis=1)[:-3]
    else:
        total = lower[3:, 2:] + upper[:-3, :-2]
    assert np.array_equal(surface.heights[: total.shape[0], : total.shape[1]], total)
    sides = [boundary] * 2 if isinstance(boundary, str) else boundary
    mirrored = [n * (1 + (side == "mirror")) for n, side in zip(total.shape, sides)]
    assert surface.heights.shape == tuple(mirrored)
    assert surface.sizes == tuple(mirrored)


@pytest.mark.parametrize(
    ("mirrored", "as_mirrored"),
    [
        (None, lambda z: z[::-1]),
        ("x", lambda z: z[::-1]),
        ("y", lambda z: z[:, ::-1]),
        ("none", lambda z: z),
    ],
)
def test_second_scan_is_mirrored_to_face_the_first(mirrored, as_mirrored, tmp_path):
    """Mirrored prints of one body fill each other's valleys; replicas have flipped heights, too."""
    first, second = two_random_maps((14, 12), (14, 12))
    np.save("first.npy", first)
    np.save("second.npy", second)
    keys = {} if mirrored is None else {"mirrored": mirrored}
    for flip in (False, True):
        bodies = ["first.npy", {"path": "second.npy", "flip": flip} | keys]
        spec = File(kind="file", bodies=bodies, physical_sizes=(1, 1), boundary="free")
        topography = open_topography(spec)
        total = topography.rows(0, 14)
        assert np.array_equal(total, first + (-1 if flip else 1) * as_mirrored(second))
        parts = [topography.rows(i, i + 2) for i in range(0, 14, 2)]
        assert np.array_equal(np.concatenate(parts), total)


def test_missing_points_are_filled_in_each_scan():
    """They are filled with a note, or refused."""
    first, second = two_random_maps((16, 16), (8, 8))
    filled = second.copy()
    filled[3, 4] = np.mean([second[2, 4], second[4, 4], second[3, 3], second[3, 5]])
    second[3, 4] = np.nan
    np.save("first.npy", first)
    np.save("second.npy", second)
    np.save("filled.npy", filled)
    keys = {"physical_sizes": (1, 1), "boundary": "free"}
    surface = hpc_gfmd.combine_surfaces("first.npy", "second.npy", fill="harmonic", **keys)
    expected = hpc_gfmd.combine_surfaces("first.npy", "filled.npy", **keys)
    assert np.allclose(surface.heights, expected.heights, rtol=0, atol=1e-14)
    assert "1 points (1.6 %) filled" in surface.prepared
    with refused(r"found nan at \(4, 4\) in second.npy.*fill"):  # mirrored: row 3 is row 4
        hpc_gfmd.combine_surfaces("first.npy", "second.npy", **keys)


def test_a_scene_agrees_with_combine_surfaces(tmp_path, cli):
    """Each file has units of its own."""
    first, second = two_random_maps((40, 30), (12, 14))
    x = np.arange(40)[:, None]
    np.savez("first.npz", z=first + x, unit="nm", physical_sizes=[400.0, 300.0])
    np.savetxt("second.csv", 1e-3 * second, delimiter=",")
    reading = {"physical_sizes": ["0.36 um", "420 nm"], "unit": "um"}
    bodies = ["first.npz", {"path": "second.csv", "shift": ["10 nm", "-0.02 um"], **reading}]
    surface = {"kind": "file", "bodies": bodies, "detrend": "tilt", "boundary": "free"}
    tables = {"load": {"pressure": "1 MPa"}, "material": {"E_star": "1 GPa"}}
    scene = {"surface": surface, "output": {"fields": ["heights"]}, **tables}
    Path("s.toml").write_text(tomli_w.dumps(scene))
    cli.prints("run s.toml -q")
    heights = hpc_gfmd.load("contact.h5")[0].heights

    second_surface = hpc_gfmd.read_surface("second.csv", boundary="free", **reading)
    by_hand = hpc_gfmd.combine_surfaces(
        hpc_gfmd.read_surface("first.npz", boundary="free"),
        second_surface,
        shift=("10 nm", "-0.02 um"),
        detrend="tilt",
    )
    assert np.allclose(heights - heights.max(), by_hand.heights - by_hand.heights.max(), atol=1e-20)
    assert by_hand.unit == "m"
    n_x, n_y = by_hand.heights.shape
    assert cli.prints("plan s.toml").startswith(f"{n_x} x {n_y} = ")


BAD_BODIES = [
    (
        ["a.npy", {"path": "b.npy", "shift": [5, 0]}],
        {},
        "found a.npy from 0 to .* and b.npy from 5 to .* along x, allowed: a shift",
    ),
    (["a.npy", {"path": "b.npy", "shift": ["5 um", 0.0]}], {}, r"bodies\[1\].shift: found 5 um"),
    (["m.npz", "a.npy"], {}, "found m.npz in m and a.npy without a unit, allowed: both"),
    (["a.npy", {"path": "m.npz", "unit": "nm"}], {}, "m.npz has its heights in 'm'"),
    (["a.npy", "never.npy"], {}, "found never.npy, which is no file"),
    (["a.npy"], {}, "a list of two"),
    (["a.npy", {"path": "b.npy", "shft": 1}], {}, r"nearest: surface.bodies\[1\].shift"),
    (["a.npy", {"path": "b.npy", "mirrored": "z"}], {}, r"bodies\[1\].mirrored: found 'z'"),
    (["a.npy", {"path": "b.npy", "decimal": ","}], {}, "surface.decimal: found ','"),
    (["a.npy", "b.npy"], {"path": "a.npy"}, "found path and bodies, allowed: one of"),
]


def test_bad_bodies_are_refused():
    z = random_heights((12, 12))
    np.save("a.npy", z)
    np.save("b.npy", z)
    np.savez("m.npz", surface=z, unit="m", physical_sizes=[1.0, 1.0])
    for bodies, keys, words in BAD_BODIES:
        table = {"kind": "file", "bodies": bodies, "boundary": "free", "physical_sizes": [1, 1]}
        with refused(words):
            spec = Scene.from_dict({"surface": table | keys, "load": {"pressure": 1}}).surface
            open_topography(spec)


def test_bad_arguments_of_combine_surfaces_are_refused():
    z = hpc_gfmd.make_surface("wave", amplitude=0.1, n=(16, 16))
    with refused("found unit, which says how a file is read, with the first surface"):
        hpc_gfmd.combine_surfaces(z, z, unit="nm")
    with refused("found ndarray for the second surface, allowed: a path"):
        hpc_gfmd.combine_surfaces(z, np.zeros((4, 4)))
    with refused("surface.bodies"):
        hpc_gfmd.combine_surfaces(z, z, shift=1)
