"""Files as users meet them: each is read rightly, or refused in one line that says what it is."""

import json
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from contacts import random_heights
from refusal import refused

import hpc_gfmd
from hpc_gfmd.commands.init import compose
from hpc_gfmd.util.errors import SceneError
from hpc_gfmd.util.libraries import surface_topography

Z = np.round(random_heights((12, 8)), 3)
FREE = {"boundary": "free"}
SIZES = {"physical_sizes": ("1.2 um", "0.4 um"), "unit": "nm"}


def matrix(z=Z, mark=","):
    """Lines of a matrix."""
    return "".join(mark.join(map(str, row)) + "\n" for row in z)


def points(dx=0.1, dy=0.05):
    """Lines x,y,z."""
    return "".join(f"{dx * i:.3f},{dy * j:.3f},{z}\n" for (i, j), z in np.ndenumerate(Z))


def zygo(pitch="2e-07", unit_lines=96):
    """A text of Zygo with a hole at (2, 5); unit_lines: how many points are written."""
    lines = [
        "Zygo XYZ Data File - Format 1",
        '0 8 3 5 "Tue Jan 02 10:00:00 2024"',
        "0 0 12 8 1 255",
        "3 4 12 8",
        *('""',) * 3,
        f"0 0.5 6.328e-07 0.5 1 0 {pitch} 1704189600",
        '3 2 0 0 0 0 0 ""',
        "0 0 1 33 0 0 0.1 60.4 2 50",
        "0 1 100 0 0 0 0 0 0 0",
        '0 ""',
        "1 5 0",
        "#",
    ]
    rows = [f"{3 + i} {4 + j} {Z[i, j]}" for j in range(8) for i in range(12)]
    rows[5 * 12 + 2] = "5 9 No Data"
    return "\n".join([*lines, *rows[:unit_lines], "#"]) + "\n"


def test_pixels_of_zygo_have_the_pitch_and_the_unit_of_the_format():
    Path("z.xyz").write_text(zygo())
    surface = hpc_gfmd.read_surface("z.xyz", fill="harmonic", **FREE)
    assert surface.sizes == pytest.approx((2.4e-6, 1.6e-6))
    measured = np.ones(Z.shape, bool)
    measured[2, 5] = False
    assert surface.heights[measured] == pytest.approx(1e-6 * Z[measured])
    assert any("in um" in note for note in surface.notes)
    with refused(r"found nan at \(2, 5\)"):
        hpc_gfmd.read_surface("z.xyz", **FREE)
    in_nm = hpc_gfmd.read_surface("z.xyz", fill="harmonic", unit="nm", **FREE)
    assert in_nm.heights[measured] == pytest.approx(1e-9 * Z[measured])
    with refused("surface.skip_lines: found 14, but z.xyz is read as zygo xyz"):
        hpc_gfmd.read_surface("z.xyz", skip_lines=14, unit="um", **FREE)


def test_damaged_texts_of_zygo_are_refused():
    Path("z.xyz").write_text(zygo(pitch="0"))
    with refused("surface.physical_sizes: not given, and in z.xyz in 'px'"):
        hpc_gfmd.read_surface("z.xyz", fill="harmonic", **FREE)
    Path("z.xyz").write_text(zygo(unit_lines=90))
    with refused("found 90 lines of 3 numbers, allowed: 12 x 8 lines"):
        hpc_gfmd.read_surface("z.xyz", fill="harmonic", **FREE)
    Path("z.xyz").write_text("Zygo XYZ Data File - Format 1\n1 2\n#\n0 0 1.0\n")
    with refused("its header has no points in line 4 or no distance"):
        hpc_gfmd.read_surface("z.xyz", **FREE)


def test_cells_of_esri_grids_give_the_sizes():
    """In the unit of the heights, with a note; rows may stand in one line."""
    head = "ncols 12\nnrows 8\nxllcorner 100\nyllcorner 200\n"
    lines = matrix(Z.T, " ")
    texts = {
        (24.0, 16.0): f"{head}cellsize 2.0\n{lines}",
        (24.0, 24.0): f"{head}dx 2.0\ndy 3.0\n{lines}",
        (12.0, 8.0): f"{head}cellsize 1.0\n{lines.replace(chr(10), ' ')}\n",
    }
    for sizes, text in texts.items():
        Path("z.asc").write_text(text)
        surface = hpc_gfmd.read_surface("z.asc", unit="m", **FREE)
        assert surface.sizes == sizes
        assert surface.heights == pytest.approx(Z)
        assert any("x and y in z.asc are taken in m" in note for note in surface.notes)
        with refused("surface.unit: not given .* surface.xy_unit, where"):
            hpc_gfmd.read_surface("z.asc", **FREE)


def test_x_and_y_in_another_unit_than_the_heights():
    Path("z.csv").write_text(points())
    keys = FREE | {"unit": "nm", "xy_unit": "um"}
    surface = hpc_gfmd.read_surface("z.csv", **keys)
    assert surface.sizes == pytest.approx((1.2e-6, 4e-7))
    assert surface.heights == pytest.approx(1e-9 * Z)
    assert not any("taken in" in note for note in surface.notes)
    in_keys = hpc_gfmd.read_surface("z.csv", physical_sizes=(2.4, 0.8), **keys)
    assert in_keys.sizes == pytest.approx((2.4e-6, 8e-7))
    part = hpc_gfmd.read_surface("z.csv", crop=(0.0, 0.0, 0.6, 0.4), **keys)
    assert part.sizes == pytest.approx((6e-7, 4e-7))
    with refused("surface.unit: not given for the heights"):
        hpc_gfmd.read_surface("z.csv", xy_unit="um", **FREE)
    Path("z.csv").write_text("x [mm],y [mm],z [nm]\n" + points())
    with refused("surface.xy_unit: found 'um', but z.csv has x and y in 'mm'"):
        hpc_gfmd.read_surface("z.csv", xy_unit="um", **FREE)


def test_init_does_not_speak_of_sizes_that_nobody_set():
    Path("z.csv").write_text(points())
    _, _, notes = compose("z.csv", Path("a.toml"))[:3]
    assert any("1.2 x 0.4" in note for note in notes)
    assert not any("1 x 1" in note for note in notes)


def test_a_file_of_a_zip_is_named():
    with zipfile.ZipFile("z.zip", "w") as archive:
        archive.writestr("a.csv", matrix())
        archive.writestr("scans/b.csv", matrix(-Z))
        archive.writestr("__MACOSX/._a.csv", b"\0\1")
    with refused("surface.dataset: not given, z.zip holds 2 files, .*: 'a.csv', 'scans/b.csv'"):
        hpc_gfmd.read_surface("z.zip", **SIZES, **FREE)
    with refused("surface.dataset: found 'c.csv', z.zip holds 2 files"):
        hpc_gfmd.read_surface("z.zip", dataset="c.csv", **SIZES, **FREE)
    surface = hpc_gfmd.read_surface("z.zip", dataset="scans/b.csv", **SIZES, **FREE)
    assert surface.heights == pytest.approx(-1e-9 * Z)


def test_a_map_of_a_container_is_named():
    """Profiles are left out; equal names get numbers."""
    library = surface_topography()
    from SurfaceTopography.Container.SurfaceContainer import InMemorySurfaceContainer

    maps = [library.Topography(k * Z, (1.2, 0.4), unit="um", info={"name": "wall"}) for k in (1, 2)]
    profile = library.UniformLineScan(Z[:, 0], 3.0, unit="um", info={"name": "line"})
    InMemorySurfaceContainer([profile, *maps]).to_zip("z.zip")
    with refused("z.zip holds 2 maps, allowed: one of 'wall', 'wall \\(2\\)'"):
        hpc_gfmd.read_surface("z.zip", **FREE)
    with refused("found 'line', which is a profile, z.zip holds 2 maps"):
        hpc_gfmd.read_surface("z.zip", dataset="line", **FREE)
    surface = hpc_gfmd.read_surface("z.zip", dataset="wall (2)", **FREE)
    assert surface.heights == pytest.approx(2e-6 * Z)
    assert surface.sizes == pytest.approx((1.2e-6, 4e-7))
    InMemorySurfaceContainer([profile]).to_zip("z.zip")
    with refused("it lists only profiles"):
        hpc_gfmd.read_surface("z.zip", **FREE)


def test_a_container_says_scale_sizes_and_filters():
    """As a website writes it: the file that was uploaded, and what its owner said of it."""
    wall = {
        "name": "wall",
        "datafile": {"original": "wall.npy"},
        "size": [1.2, 0.4],
        "unit": "um",
        "height_scale": 1e-3,
        "detrend_mode": "height",
    }
    tilted = Z + 0.3 * np.arange(12)[:, None]
    np.save("wall.npy", tilted)
    with zipfile.ZipFile("z.zip", "w") as archive:
        archive.write("wall.npy")
        index = {"surfaces": [{"name": "s", "topographies": [wall]}]}
        archive.writestr("index.json", json.dumps(index))
    surface = hpc_gfmd.read_surface("z.zip", **FREE)
    plain = hpc_gfmd.prepare_surface(tilted, detrend="tilt", **SIZES, **FREE)
    assert surface.sizes == pytest.approx(plain.sizes)
    assert surface.heights == pytest.approx(plain.heights)
    assert any("filtered by 'height'" in note for note in surface.notes)


def profiles():
    """Write profiles (line scans) in many formats; returns the names of the files."""
    z = Z.ravel()
    lines = [(f"{0.1 * k:.2f}", height) for k, height in enumerate(z)]
    texts = {
        "one.txt": "".join(f"{height}\n" for height in z),
        "two.txt": "".join(f"{x} {height}\n" for x, height in lines),
        "along_x.txt": "".join(f"{x} 0.0 {height}\n" for x, height in lines),
        "along_y.csv": "x,y,z\n" + "".join(f"3.0,{x},{height}\n" for x, height in lines),
        "slanted.txt": "".join(f"{x} {9 - 2 * float(x):.2f} {h}\n" for x, h in lines),
        "dektak.csv": "Scan Parameters,\nID,0\nScan Length,2000 um\n\nScan Data\n\n"
        "Lateral um,Raw Micrometer,\n" + "".join(f"{x},{height},\n" for x, height in lines),
        "lens.hfm": "X;Y;valid\n[mm];[um];[1/0]\n" + "".join(f"{x};{h};1\n" for x, h in lines),
    }
    for name, text in texts.items():
        Path(name).write_text(text)
    np.save("z.npy", z)
    np.savez("z.npz", surface=z)
    with h5py.File("z.h5", "w") as file:
        file["surface"] = z
    surface_topography().UniformLineScan(z, 3.0, unit="um").to_netcdf("z.nc")
    return [*texts, "z.npy", "z.npz", "z.h5", "z.nc"]


def test_profiles_are_refused_as_profiles():
    for name in profiles():
        with pytest.raises(SceneError, match="profile") as refusal:
            hpc_gfmd.read_surface(name, **SIZES, **FREE)
        assert name in str(refusal.value)
        assert "\n" not in str(refusal.value)
    profile = surface_topography().UniformLineScan(Z[0], 3.0)
    for take in (
        lambda: hpc_gfmd.prepare_surface(profile, **FREE),
        lambda: hpc_gfmd.combine_surfaces(profile, profile),
    ):
        with refused("a profile"):
            take()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Zygo ASCII Data File - Format 2\n0 0 0 0\n#\n1 2 3\n4 5 6\n", "Zygo's text of phases"),
        ("DSAA\n8 12\n0 7\n0 11\n-1 1\n" + matrix(mark=" "), "a text grid of Surfer"),
    ],
)
def test_texts_that_would_be_misread_are_refused_by_name(text, words):
    Path("z.txt").write_text(text)
    with refused(words):
        hpc_gfmd.read_surface("z.txt", **SIZES, **FREE)
