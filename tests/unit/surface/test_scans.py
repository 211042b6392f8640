"""Height maps as instruments and programs write them: read correctly, or refused with a reason."""

import re
import struct
import zipfile
from itertools import product
from pathlib import Path

import h5py
import netcdf
import numpy as np
import pytest
import tifffile
from contacts import opened, random_heights
from refusal import refused

import hpc_gfmd
from hpc_gfmd.commands.init import compose
from hpc_gfmd.surface.heights import StoredRows
from hpc_gfmd.surface.quality import edges_of, quality_of
from hpc_gfmd.surface.topography import Topography
from hpc_gfmd.util.libraries import surface_topography

Z = np.round(20 * random_heights((12, 8)), 3)  # nm
SIZES = (1.2e-6, 0.4e-6)
KEYS = {"physical_sizes": ("1.2 um", "0.4 um"), "unit": "nm"}
SMALL = {"physical_sizes": ("4 um", "4 um"), "unit": "nm"}
HOLE = (2, 5)


def heights(path, **keys):
    """Heights of a file in nm, nan at missing points."""
    topography = opened(path, **keys)
    return 1e9 * topography.rows(0, topography.n[0])


def is_map(z, wanted=Z):
    """Whether heights in nm agree with the wanted ones; nan agrees with nan."""
    return np.allclose(z, wanted, rtol=1e-6, atol=1e-5, equal_nan=True)


def table_text(rows, separator="\t"):
    """Rows as lines of text."""
    return "\n".join(separator.join(map(str, row)) for row in rows) + "\n"


def with_hole(z=Z):
    z = z.copy()
    z[HOLE] = np.nan
    return z


# Text: nothing is dropped


UNKNOWN = ["?", "off", "n.v.", "1_0", "1.5.2", "0x1F", "12e", "1,5"]


def test_unknown_tokens_are_named():
    """The message has the line and the token, unless surface.missing lists it."""
    for token, lines in product(UNKNOWN, ([0], [3], [11], [3, 11], [0, 3, 5, 11])):
        rows = Z.astype(str)
        rows[lines, 5] = token
        Path("z.txt").write_text(table_text(rows))
        with refused(f"line {lines[0] + 1}: found '{re.escape(token)}'|in line {lines[0] + 1}"):
            heights("z.txt", **KEYS)
        z = heights("z.txt", missing=[token], **KEYS)
        assert np.isnan(z[lines, 5]).all()
        assert np.isnan(z).sum() == len(lines)


def test_channels_are_selected_by_name():
    """The text of Gwyddion's export of all channels."""
    head = "# Channel: {}\n# Width: 1.2 µm\n# Height: 0.4 µm\n# Value units: {}\n"
    parts = [("Error", "V", Z), ("Up", "nm", Z), ("Down", "nm", -Z)]
    Path("z.txt").write_text("\n".join(head.format(*p[:2]) + table_text(p[2].T) for p in parts))
    assert is_map(heights("z.txt"))
    assert is_map(heights("z.txt", dataset="Down"), -Z)
    assert any("'Up'" in note and "Down" in note for note in map(str, opened("z.txt").notes))
    with refused(r"surface.dataset: found 'Left', allowed.* Up, Down"):
        heights("z.txt", dataset="Left")


def test_ambiguous_first_lines_are_refused():
    Path("z.txt").write_text("1 2 3 4 5 6 7\n" + table_text(Z, " "))
    with refused("line 1: found 7 numbers, allowed: 8"):
        heights("z.txt", **KEYS)
    assert is_map(heights("z.txt", skip_lines=1, **KEYS))


# Text: tables with axes

X = np.arange(12) * 0.1
Y = np.arange(8) * 0.05


@pytest.mark.parametrize(
    ("index", "columns", "note_words"),
    [
        (range(12), range(8), "numbers of"),
        (range(1, 13), [*"abcdefgh"], "numbers of"),
        (X, Y, "coordinates of the"),
        (X[::-1], Y, "coordinates of the"),
        (None, range(8), "numbers of"),
        (None, [*"abcdefgh"], ""),
        (range(12), None, "numbers of"),
    ],
)
@pytest.mark.parametrize("sep", [",", ";", "\t"])
def test_tables_of_pandas(index, columns, note_words, sep):
    import pandas as pd

    table = pd.DataFrame(Z + 0.0005, index, columns)
    table.to_csv("z.csv", index=index is not None, header=columns is not None, sep=sep)
    topography = opened("z.csv", **KEYS)
    turned = Z[::-1] if index is not None and index[0] > index[1] else Z
    assert is_map(1e9 * topography.rows(0, 12), turned + 0.0005)
    assert any(note_words in str(note) for note in topography.notes)


def test_a_mark_of_missing_points_among_coordinates_is_no_gap():
    """An index 0, 1, 2, ... stays one where 1 marks missing heights."""
    z = with_hole()
    rows = [["", *range(8)], *([k, *row] for k, row in enumerate(np.where(np.isnan(z), 1, z)))]
    Path("z.csv").write_text(table_text(rows, ","))
    assert is_map(heights("z.csv", missing=["1"], **KEYS), z)


def test_possible_coordinates_need_a_key():
    """A line or column that rises evenly is refused without surface.coordinates; a plane, in which
    all lines do, is heights."""
    whole = np.round(Z).astype(int)
    whole[0] = range(8)
    Path("z.txt").write_text(table_text(whole))
    with refused('first line .*surface.coordinates = "line"'):
        heights("z.txt", **KEYS)
    assert is_map(heights("z.txt", coordinates="none", **KEYS), whole)
    assert is_map(heights("z.txt", coordinates="line", **KEYS), whole[1:])
    plane = np.arange(96).reshape(12, 8)
    Path("z.txt").write_text(table_text(plane))
    assert is_map(heights("z.txt", **KEYS), plane)
    for rows in (
        [[1, 2, 3, 4], [5, 6, 3, 1], [2, 4, 1, 3], [4, 3, 2, 1]],
        [[1, 2, 3, 4], [2, 1, 4, 3], [3, 4, 1, 2], [4, 3, 2, 1]],
    ):
        Path("z.txt").write_text(table_text(rows))
        assert is_map(heights("z.txt", **SMALL), rows)
    Path("z.txt").write_text(
        table_text([[0, 0, 1, 2], [0, 101, 105, 103], [1, 104, 107, 106], [2, 9, 5, 8]])
    )
    with refused("first line and column .*surface.coordinates"):
        heights("z.txt", **SMALL)
    assert heights("z.txt", coordinates="both", **SMALL).shape == (3, 3)


def point_rows(names, order=lambda table: table):
    """Rows of points; names: columns (x and y in um, z in nm, I an intensity)."""
    i, j = np.indices(Z.shape).reshape(2, -1)
    columns = {"x": X[i], "y": Y[j], "z": Z.ravel(), "I": np.full(96, 17)}
    table = order(np.array([columns[name[0]] for name in names]).T)
    return table.tolist()


NAMES_OF_COLUMNS = [
    ("x[um]", "y[um]", "z[nm]", "I[1]"),
    ("I[1]", "x[um]", "y[um]", "z[nm]"),
    ("z [nm]", "x [um]", "y [um]"),
    ("x (µm)", "y (µm)", "z (nm)"),
]


ORDERS = [
    lambda t: t,
    lambda t: t[::-1],
    lambda t: t[np.lexsort(t.T[[0, 1]])],
    lambda t: np.random.default_rng(1).permutation(t),
    lambda t: t[np.lexsort((-t[:, 1], t[:, 0]))],
]


def test_points_with_named_columns_in_any_order():
    for names, mark, order in product(NAMES_OF_COLUMNS, "\t;,", ORDERS):
        Path("z.xyz").write_text(table_text([names, *point_rows(names, order)], mark))
        topography = opened("z.xyz")
        assert is_map(1e9 * topography.rows(0, 12)), (names, mark)
        assert topography.sizes == pytest.approx(SIZES)
        is_noted = any("column I is not used" in str(note) for note in topography.notes)
        assert is_noted == ("I[1]" in names)


GWYDDION = "# Channel: Height\n# Width: 4 µm\n# Height: 2 µm\n# Value units: nm\n"


def test_a_line_within_a_map_of_gwyddion_is_no_end_of_it():
    """A second header of Gwyddion begins another channel; any other line there is refused."""
    lines = [" ".join(map(str, row)) + "\n" for row in Z]
    for begin, within, is_read in (
        (GWYDDION, "", True),
        (GWYDDION, "# more\n", False),
        (GWYDDION, GWYDDION.replace("Channel: Height", "Channel: Other"), True),
    ):
        Path("z.txt").write_text(begin + "".join(lines[:6]) + within + "".join(lines[6:]))
        if is_read:
            assert opened("z.txt").n[1] == (6 if within else 12)
        else:
            with refused("2 blocks of numbers .6 from line 5 on, 6 from line 12 on"):
                opened("z.txt")


def test_points_with_blank_lines_that_are_no_grid_are_refused():
    """In one line; columns keep their names where blank lines end the lines of a grid."""
    x, y = np.meshgrid(np.arange(4.0), np.arange(5.0), indexing="ij")
    for moved in (0.3, 0.0):
        x[1, 1] += moved
        points = np.dstack([y, x, 10 * x + y])
        blocks = ["\n".join(" ".join(map(str, point)) for point in line) for line in points]
        Path("p.xyz").write_text("y x z\n" + "\n\n".join(blocks))
        if moved:
            with refused("no regular grid|without a height|not those of a regular grid"):
                hpc_gfmd.read_surface("p.xyz", boundary="free", unit="nm")
            x[1, 1] -= moved
    assert np.allclose(opened("p.xyz", unit="nm").rows(0, 4), 1e-9 * (10 * x + y))


# Direction of x

HEADER = "# Channel: Height\n# Width: {}\n# Height: {}\n# Value units: nm\n"


def test_header_decides_the_direction():
    """In all encodings and with decimal commas."""
    body = HEADER.format("1.2 µm", "0.4 µm") + table_text(Z.T)
    for encoding, decimal in product(("utf-8", "latin-1", "utf-8-sig", "utf-16"), ".,"):
        Path("z.txt").write_bytes(body.replace(".", decimal).encode(encoding))
        topography = opened("z.txt")
        assert topography.sizes == pytest.approx(SIZES), (encoding, decimal)
        assert is_map(1e9 * topography.rows(0, 12)), (encoding, decimal)


def test_first_axis_exchanges_axes():
    np.save("z.npy", Z)
    np.savetxt("z.txt", Z)
    turned = {"unit": "nm", "physical_sizes": KEYS["physical_sizes"][::-1]}
    for name in ("z.npy", "z.txt"):
        assert is_map(heights(name, first_axis="x", **KEYS))
        assert is_map(heights(name, first_axis="y", **turned), Z.T)
    assert any("first_axis" in str(note) for note in opened("z.txt", **KEYS).notes)
    assert not opened("z.txt", first_axis="x", **KEYS).notes


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_matlab(version):
    """The first index is x in both formats of MATLAB."""
    if version == "5":
        from scipy.io import savemat

        savemat("z.mat", {"z": Z, "dx": 0.1})
    else:
        with h5py.File("z.mat", "w", userblock_size=512) as file:
            for name, value in {"z": Z, "dx": np.array([[0.1]])}.items():
                file.create_dataset(name, data=value.T).attrs["MATLAB_class"] = np.bytes_("double")
        data = Path("z.mat").read_bytes()
        Path("z.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + data[512:])
    assert is_map(heights("z.mat", **KEYS))


# Units of length


NO_LENGTHS = ["px", "pixel", "point", "au", "Pixels", "a.u.", "Nm", "1"]


def test_units_that_are_no_length():
    for unit in NO_LENGTHS:
        Path("z.xyz").write_text(
            table_text([(f"x[{unit}]", f"y[{unit}]", "z[nm]"), *point_rows("xyz")], ",")
        )
        with refused(r"^surface.physical_sizes: not given"):
            hpc_gfmd.read_surface("z.xyz", boundary="periodic")
        assert is_map(heights("z.xyz", physical_sizes=KEYS["physical_sizes"]))
        np.savez("z.npz", z=Z, unit=unit, physical_sizes=SIZES)
        with refused(r"^surface.unit: .*|surface.physical_sizes"):
            hpc_gfmd.read_surface("z.npz", boundary="periodic")
        assert is_map(heights("z.npz", **KEYS))
        assert any("surface.unit says" in str(note) for note in opened("z.npz", **KEYS).notes)
        with refused("surface.physical_sizes"):
            hpc_gfmd.read_surface("z.npz", unit="nm", physical_sizes=(f"512 {unit}", f"512 {unit}"))


SPELLINGS = [
    ("Nanometer", 1e-9),
    ("NanoMeters", 1e-9),
    ("NM", 1e-9),
    ("Micrometre", 1e-6),
    ("Angstrom", 1e-10),
    ("Å", 1e-10),
    ("mil", 2.54e-5),
    ("Inch", 0.0254),
    ("Microns", 1e-6),
    ("μm", 1e-6),
]


def test_spellings_of_units():
    for unit, metres in SPELLINGS:
        np.savez("z.npz", z=Z, unit=unit, physical_sizes=[12.0, 4.0])
        topography = opened("z.npz")
        assert np.allclose(topography.rows(0, 12), metres * Z, rtol=1e-12)
        assert topography.sizes == pytest.approx((12 * metres, 4 * metres))


# NetCDF and Gwyddion


AXES = {name: np.arange(n) * L / n for name, n, L in zip("xy", Z.shape, SIZES)}


def packed_netcdf(path):
    """Write NetCDF 3 with 16-bit integers, a scale and a hole."""
    steps = np.round(Z / 0.0625).astype("i2")
    steps[HOLE] = -32768
    hole = np.int16(-32768)
    netcdf.write(path, steps, AXES, classic=True, scale_factor=0.0625, _FillValue=hole)


def test_packed_integers_of_netcdf():
    packed_netcdf("z.nc")
    topography = opened("z.nc")
    assert topography.sizes == pytest.approx(SIZES)
    assert is_map(1e9 * topography.rows(0, 12), with_hole(np.round(Z / 0.0625) * 0.0625))


@pytest.mark.parametrize(
    ("attributes", "stored"),
    [
        ({"valid_min": -30.0}, lambda z: np.where(np.isnan(z), -99.0, z)),
        ({"valid_max": 1e3}, lambda z: np.where(np.isnan(z), 1e4, z)),
        ({"valid_range": [-1e3, 1e3]}, lambda z: np.where(np.isnan(z), -1e4, z)),
        ({"missing_value": [-1e4, -2e4]}, lambda z: np.where(np.isnan(z), -2e4, z)),
        ({"NODATA": -9999.9}, lambda z: np.where(np.isnan(z), -9999.9, z).astype("f4")),
        (
            {
                "_Unsigned": "true",
                "scale_factor": 0.001,
                "add_offset": -32.0,
                "_FillValue": np.int16(-1),
            },
            lambda z: (
                np.where(np.isnan(z), 65535, np.round((z + 32) / 0.001)).astype("u2").view("i2")
            ),
        ),
    ],
)
def test_attributes_for_missing_values(attributes, stored):
    z = np.clip(Z, -29, 29)
    with h5py.File("z.nc", "w") as file:
        file.create_dataset("h", data=stored(with_hole(z))).attrs.update(attributes)
    assert is_map(heights("z.nc", **KEYS), with_hole(z))


def test_topography_precedes_other_channels():
    channels = {"Error": -Z, "Phase": Z / 3, "ZSensor": Z}
    import gwyfile

    container = {}
    for k, (name, z) in enumerate(channels.items()):
        container[f"/{k}/data/title"] = name
        container[f"/{k}/data"] = gwyfile.objects.GwyDataField(
            1e-9 * z.T,
            xreal=1.2e-6,
            yreal=4e-7,
            si_unit_xy=gwyfile.objects.GwySIUnit(unitstr="m"),
            si_unit_z=gwyfile.objects.GwySIUnit(unitstr="m"),
        )
    gwyfile.objects.GwyContainer(container).tofile("z.gwy")
    assert is_map(heights("z.gwy"))
    notes = compose("z.gwy", Path("a.toml"))[2]
    assert any("ZSensor" in line and "Error, Phase" in line for line in notes)
    surface = hpc_gfmd.read_surface("z.gwy", boundary="periodic")
    assert any("channel 'ZSensor'" in note for note in surface.notes)
    named = hpc_gfmd.read_surface("z.gwy", boundary="periodic", dataset="Error")
    assert is_map(1e9 * named.heights, -Z)
    assert not any("channel" in note for note in named.notes)
    with refused("surface.dataset: found 'Nix', allowed in this file: 'Error', 'Phase', 'ZSensor'"):
        hpc_gfmd.read_surface("z.gwy", dataset="Nix")


# Missing values


def test_nodata_of_geotiff():
    for number, dtype in product((-9999, -32768, 3.4028234663852886e38, 0), ("f4", "f8")):
        z = np.where(np.isnan(with_hole()), number, Z).astype(dtype)
        tag = [(42113, "s", 0, f"{number}", True)]
        tifffile.imwrite("z.tif", z.T, extratags=tag)
        assert is_map(heights("z.tif", **KEYS), with_hole(Z.astype(dtype))), (number, dtype)


def test_nodata_of_integers():
    steps = np.round(1000 + 10 * Z).astype(np.uint16)
    steps[HOLE] = 0
    tifffile.imwrite("z.tif", steps.T, extratags=[(42113, "s", 0, "0", True)])
    topography = opened("z.tif", height_range=["-100 nm", "6453.5 nm"], **KEYS)
    z = 1e9 * topography.rows(0, 12)
    assert np.allclose(z, with_hole(np.round(10 * Z) / 10), equal_nan=True, atol=1e-3)
    assert any("0 to 65535" in str(note) for note in topography.notes)


def test_nodata_of_esri():
    """Lines run along x, as in images."""
    head = "ncols 12\nnrows 8\nxllcorner 0\nyllcorner 0\ncellsize 0.1\n"
    z = np.where(np.isnan(with_hole()), -9999, Z)
    for name in ("NODATA_value", "nodata_value", "NODATA_VALUE"):
        Path("z.asc").write_text(f"{head}{name} -9999\n" + table_text(z.T, " "))
        assert is_map(heights("z.asc", **KEYS), with_hole()), name
    Path("z.asc").write_text(f"{head}{name} -9999\n" + table_text(z.T[:-1], " "))
    with refused("found 7 lines of 12 numbers, allowed: 8 of 12"):
        heights("z.asc", **KEYS)


def test_missing_numbers_of_the_scene():
    z = np.where(np.isnan(with_hole()), -9999, Z)
    np.savetxt("z.txt", z)
    np.save("z.npy", z)
    tifffile.imwrite("z.tif", z.T)
    for name, written in product(("z.txt", "z.npy", "z.tif"), ("-9999", "-9999.0", "-9.999e3")):
        assert is_map(heights(name, missing=[written], **KEYS), with_hole()), (name, written)


# Decreasing coordinates


def test_decreasing_coordinates_are_reversed():
    """Along named axes in any order."""
    for falling, classic, names in product(("x", "y", "xy", ""), (False, True), ("xy", "YX")):
        axes = {name: AXES[name.lower()] for name in names}
        z = Z if names == "xy" else Z.T
        for axis, name in enumerate(names):
            if name.lower() in falling:
                axes[name] = axes[name][::-1]
                z = np.flip(z, axis)
        path = f"{names} {falling} {classic}.nc"
        netcdf.write(path, z, axes, classic=classic)
        topography = opened(path)
        assert is_map(1e9 * topography.rows(0, 12)), path
        assert is_map(1e9 * topography.rows(3, 7), Z[3:7])
        crop = ("0 m", "0 m", "0.3 um", "0.1 um")
        cropped = hpc_gfmd.read_surface(path, crop=crop, boundary="free")
        assert is_map(1e9 * cropped.heights, Z[:3, :2])


# Reasons of refusals


def write_x3p(change, folder=""):
    """Write z.x3p with a changed description, in a folder of the archive."""
    topography = surface_topography().Topography(Z, (1200, 400), unit="nm")
    topography.to_x3p("plain.x3p")
    with zipfile.ZipFile("plain.x3p") as archive, zipfile.ZipFile("z.x3p", "w") as rewritten:
        for name in archive.namelist():
            data = archive.read(name)
            rewritten.writestr(folder + name, change(data) if name == "main.xml" else data)


def with_en_dash(xml):
    return xml.replace(b"ISO5436 - 2000", "ISO5436 – 2000".encode())


def test_x3p_of_other_programs():
    for folder in ("", "scan/"):
        write_x3p(with_en_dash, folder)
        assert is_map(heights("z.x3p"))


def test_reason_of_the_reader_is_in_the_message():
    write_x3p(lambda xml: xml.replace(b"<FeatureType>SUR", b"<FeatureType>PCL"))
    with refused("FeatureType should be 'SUR'"):
        heights("z.x3p")
    Path("z.gwy").write_bytes(b"GWYP" + b"\0" * 40)
    with refused("z.gwy cannot be read"):
        heights("z.gwy")


def test_nms_with_a_spacing_in_nm():
    head = bytearray(3468)
    struct.pack_into("<2d", head, 16, 0.0, 1.0)
    struct.pack_into("<2I2d", head, 1368, 12, 8, 312.5, 312.5)
    Path("z.nms").write_bytes(bytes(head) + np.arange(96, dtype="<u2").tobytes())
    topography = opened("z.nms")
    assert topography.sizes == pytest.approx((12 * 312.5e-9, 8 * 312.5e-9))


OF_TEXT = [
    ("skip_lines", 3),
    ("decimal", ","),
    ("coordinates", "both"),
    ("height_range", [0.0, 1.0]),
]


def test_keys_of_other_formats_are_refused():
    np.save("z.npy", Z)
    for key, value in OF_TEXT:
        with refused(f"surface.{key}: found .*z.npy is read as npy"):
            opened("z.npy", **KEYS, **{key: value})


# Notes on preparation


def lens(n=32, radius=5e-4, size=3.2e-5):
    """Write lens.npz, a spherical cap."""
    x = (np.arange(n) - (n - 1) / 2) * size / n
    np.savez(
        "lens.npz", z=-(x[:, None] ** 2 + x**2) / (2 * radius), unit="m", physical_sizes=[size] * 2
    )


def test_a_lens_is_told_about_free_edges_and_radius():
    lens()
    with refused('^surface.boundary: .* along x meet in a kink.*"mirror".*"free".*"periodic"'):
        hpc_gfmd.read_surface("lens.npz")
    *kinks, form = hpc_gfmd.read_surface("lens.npz", boundary="periodic").notes
    for axis, note in zip("xy", kinks, strict=True):
        assert f"opposite edges along {axis}" in note
    (note,) = hpc_gfmd.read_surface("lens.npz", boundary="mirror").notes
    assert note == form
    assert "curved, along x by" in note
    assert 'boundary = "free"' in note
    assert "radius" in note
    assert not hpc_gfmd.read_surface("lens.npz", boundary="free").notes
    z = random_heights((64, 64))
    assert not any(
        "kink" in note for note in hpc_gfmd.prepare_surface(z, physical_sizes=(1, 1)).notes
    )


def test_quality_is_noted_where_a_map_is_read_and_not_where_it_is_solved():
    """A plane with the variance of what lies on it is half of the tilt that is noted; noise has
    power at the shortest waves, a smooth wave has none; a solve looks at the edges only."""
    x, y = np.meshgrid(np.arange(300) / 300, np.arange(200) / 200, indexing="ij")
    smooth = np.cos(2 * np.pi * (2 * x + y))
    for slope, is_tilted in ((1.0, False), (12.0, True)):
        notes = hpc_gfmd.prepare_surface(smooth + slope * x, boundary="periodic").notes
        assert any("is tilt" in note for note in notes) == is_tilted
        assert any("opposite edges along x" in note for note in notes)
        assert not any("along y" in note or "resolved" in note for note in notes)
    rough = random_heights((64, 64))
    (note,) = hpc_gfmd.prepare_surface(0.1 * rough).notes
    assert "not resolved" in note
    assert "resolved" not in (hpc_gfmd.solve(1e-3 * rough, 1e-4).note or "")


def test_what_a_person_is_told_of_a_map_is_true():
    """Statistics of a map whose numbers are known: a wave of 50 points and a plane."""
    n = (400, 300)
    x, y = np.meshgrid(*(np.arange(k) for k in n), indexing="ij")
    z = 0.2 * np.cos(2 * np.pi * x / 50) + 3e-3 * y
    quality = quality_of(z, n)
    variances = 0.2**2 / 2, 3e-3**2 * (n[1] ** 2 - 1) / 12
    assert quality.h_rms == pytest.approx(sum(variances) ** 0.5)
    assert quality.tilt == pytest.approx(variances[1] / sum(variances), rel=0.01)
    steps = 2 * (0.2 * np.sin(np.pi / 50)) ** 2, 3e-3**2
    assert quality.g_rms == pytest.approx(sum(steps) ** 0.5, rel=0.01)
    assert quality.typical == pytest.approx((2 * steps[0]) ** 0.5 * np.sin(np.pi / 4), rel=0.1)
    edges = edges_of(Topography(n, n, StoredRows(z)))
    assert edges.jumps[0] < 2
    assert edges.jumps[1] == pytest.approx(n[1] - 1)


def test_filling_agrees_with_factorisation():
    """Holes of all sizes at edges, a third of all points, and all but every eighth along x and y:
    the equations, one for each point, are solved by SciPy's factorisation."""
    from scipy.sparse import diags_array, eye_array, kron
    from scipy.sparse.linalg import spsolve

    n = (61, 54)
    z = np.cumsum(random_heights(n), axis=0)
    i, j = np.indices(n)
    chain = [diags_array([1.0, 1.0], offsets=[-1, 1], shape=(k, k)) for k in n]
    bonds = (kron(chain[0], eye_array(n[1])) + kron(eye_array(n[0]), chain[1])).tocsr()
    matrix = diags_array(bonds.sum(axis=1)).tocsr() - bonds
    holes = [
        (i < 30) & (j < 45),
        np.random.default_rng(0).random(n) < 1 / 3,
        (i % 8 > 0) | (j % 8 > 0),
    ]
    for hole in holes:
        points = np.flatnonzero(hole)
        known = np.where(hole, 0.0, z)
        expected = spsolve(matrix[points][:, points].tocsc(), -(matrix @ known.ravel())[points])
        surface = hpc_gfmd.prepare_surface(
            np.where(hole, np.nan, z), fill="harmonic", boundary="free"
        )
        assert np.allclose(surface.heights[hole], expected, rtol=0, atol=1e-11 * np.ptp(z))
        assert np.array_equal(surface.heights[~hole], z[~hole])
