"""Walls from Fourier coefficients: a map and its coefficients are one surface; wrong files."""

import re

import h5py
import numpy as np
import pytest
from contacts import random_heights
from refusal import refused

import hpc_gfmd
from hpc_gfmd.surface import fourier


def wall(path, n, **keys):
    return hpc_gfmd.make_surface("fourier", path=str(path), n=n, **keys)


def centred(z):
    return z - z.mean()


@pytest.mark.parametrize("n", [(12, 10), (64, 48), (9, 7)])
def test_a_map_from_its_coefficients(tmp_path, n):
    """Also with all modes of half the points, and of noise; on twice as fine a grid it agrees."""
    z = random_heights(n)
    np.save(tmp_path / "c.npy", np.fft.fft2(z) / z.size)
    assert centred(wall(tmp_path / "c.npy", n).heights) == pytest.approx(centred(z), abs=1e-14)
    finer = wall(tmp_path / "c.npy", (2 * n[0], 4 * n[1])).heights[::2, ::4]
    assert centred(finer) == pytest.approx(centred(z), abs=1e-13)


@pytest.mark.parametrize("name", ["c.txt", "c.npz", "c.h5"])
def test_lists_of_both_signs_or_of_one(tmp_path, name):
    k = np.array([[1, 0], [2, 3], [-2, 1], [0, -4], [-1, 0]])  # the last one is that of the first
    c = np.array([1 + 2j, 0.3j, 0.5, 0.1 - 0.2j, 1 - 2j])
    path = tmp_path / name
    if name == "c.txt":
        rows = [f"{a}, {b}, {x.real}, {x.imag}" for (a, b), x in zip(k, c)]
        path.write_text("# k_x, k_y, c\n" + "\n".join(rows))
    elif name == "c.npz":
        np.savez(path, indices=k, coefficients=c)
    else:
        with h5py.File(path, "w") as file:
            file.update({"indices": k, "coefficients": c})
    n = np.array([16, 12])
    r = np.stack(np.meshgrid(*(np.arange(m) / m for m in n), indexing="ij"), axis=-1)
    z = sum(2 * (x * np.exp(2j * np.pi * (r @ mode))).real for mode, x in zip(k[:-1], c))
    made = wall(path, n)
    assert made.heights == pytest.approx(z - z.max(), abs=1e-13)
    scaled = wall(path, n, h_rms="2 um", physical_sizes=("1 mm", "1 mm"), unit="nm")
    assert scaled.h_rms == pytest.approx(2e-6)


def test_units_of_coefficients(tmp_path):
    path = tmp_path / "c.txt"
    path.write_text("1 0 1.0 0.0\n")
    made = wall(path, (8, 8), unit="nm", physical_sizes=("1 um", "1 um"))
    assert np.ptp(made.heights) == pytest.approx(4e-9)
    assert made.unit == "m"


def test_arrays_without_numbers_are_refused_and_mistakes_are_not(tmp_path, monkeypatch):
    path = tmp_path / "c.npz"
    np.savez(path, indices=[[1, 0]], coefficients=np.zeros(1, "f8, U3"))
    with refused(r"cannot read .*: Cannot cast array data"):
        wall(path, (8, 8))
    monkeypatch.setattr(fourier, "h5py", None)
    with pytest.raises(AttributeError):
        wall(path, (8, 8))


WRONG = [
    ("9 0 1 0\n", "found 9 periods along x"),
    ("1 0 1 0\n1 0 1 0\n", "found mode (1, 0) twice"),
    ("1 0 1 0\n-1 0 2 0\n", "found mode (1, 0) and a mirror that is not conjugate"),
    ("1.5 0 1 0\n", "found broken mode numbers"),
    ("1 0 nan 0\n", "all finite"),
    ("1 0 1\n", "found 3 columns"),
    ("1 0 a 0\n", "cannot read"),
    ("0 0 1 0\n", "found no waves"),
]


def test_wrong_coefficients_are_refused_in_one_line(tmp_path):
    path = tmp_path / "c.txt"
    for text, words in WRONG:
        path.write_text(text)
        with refused(re.escape(words)):
            wall(path, (16, 16))
    path.write_text("1 0 1 0\n")
    with refused("surface.unit: found none and physical_sizes with units"):
        wall(path, (16, 16), physical_sizes=("1 um", "1 um"))
    np.save(tmp_path / "c.npy", np.fft.rfft2(random_heights((8, 8))))
    with refused("no transform of real heights"):
        wall(tmp_path / "c.npy", (16, 16))
