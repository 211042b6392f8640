"""Height maps of all formats: sizes and units come from the file or the scene, without guessing."""

import bz2
import gzip
import zipfile
from functools import partial
from pathlib import Path

import h5py
import netcdf
import numpy as np
import pytest
import tifffile
from contacts import opened, random_heights
from PIL import Image
from refusal import refused

import hpc_gfmd
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.runs.surfaces import surface_of_topography
from hpc_gfmd.scene import Scene
from hpc_gfmd.util.libraries import surface_topography

# in m; numbers of points and pixel sizes differ along x and y, which reveals exchanged axes
N = (12, 8)
SIZES = (1.2e-6, 0.4e-6)
UNITS = {"nm": 1e-9, "um": 1e-6, "m": 1.0}
Z = 2e-8 * random_heights(N)


def topography(unit, periodic=True, heights=Z):
    """SurfaceTopography's Topography of the heights in a unit."""
    scale = UNITS[unit]
    sizes = tuple(size / scale for size in SIZES)
    return surface_topography().Topography(
        heights / scale, sizes, unit={"um": "µm"}.get(unit, unit), periodic=periodic
    )


def coordinates(unit, offset=0.0):
    """Coordinates of points in a unit; offset: of the first one, in grid points."""
    return [(np.arange(n) + offset) * L / n / UNITS[unit] for n, L in zip(N, SIZES)]


def cf(path, unit):
    """Write NetCDF 3 as other programs do: coordinates of points, y first."""
    x, y = coordinates(unit)
    netcdf.write(path, Z.T / UNITS[unit], {"y": y, "x": x}, unit, unit, classic=True)


def netcdf4(path, unit):
    """Write NetCDF 4 with coordinates at cell centres."""
    x, y = coordinates(unit, 0.5)
    netcdf.write(path, Z / UNITS[unit], {"x": x, "y": y}, unit, unit)


def with_attributes(path, unit):
    """Write HDF5 with sizes and unit as attributes of the dataset."""
    with h5py.File(path, "w") as file:
        file["surface"] = Z / UNITS[unit]
        file["surface"].attrs.update(
            physical_sizes=np.array(SIZES) / UNITS[unit], unit=unit, periodic=True
        )


FORMATS = {  # name: function that writes (path, unit) by SurfaceTopography, SciPy or NumPy
    "z.x3p": lambda p, u: topography(u).to_x3p(str(p)),
    "z.gwy": lambda p, u: topography(u).to_gwy(str(p)),
    "z.nc": lambda p, u: topography(u).to_netcdf(str(p)),
    "z.asc": lambda p, u: topography(u).to_matrix(str(p)),
    "z.txt": lambda p, u: topography(u, False).to_matrix(str(p)),
    "cf.nc": cf,
    "four.nc": netcdf4,
    "z.h5": with_attributes,
    "z.npz": lambda p, u: np.savez(
        p, z=Z / UNITS[u], physical_sizes=np.array(SIZES) / UNITS[u], unit=u
    ),
}
BARE = {
    "b.npy": np.save,
    "b.npz": lambda p, z: np.savez(p, z=z),
    "b.txt": np.savetxt,
    "b.asc": np.savetxt,
    "b.CSV": lambda p, z: np.savetxt(p, z, delimiter=","),
    "b.dat": lambda p, z: np.savetxt(p, z, delimiter=";"),
    "commented.txt": lambda p, z: np.savetxt(p, z, header="my heights"),
}
BY_HAND = {"physical_sizes": ("1.2 um", "0.4 um"), "unit": "nm"}
SUFFIXES = ("", ".dat", ".hdf", ".txt", ".tif", ".nc", ".nc4", ".cdf", ".h5", ".map", ".x3p")


@pytest.fixture(scope="module")
def plain():
    """The solution for the heights as an array of plain numbers in SI units."""
    return hpc_gfmd.solve(Z, 1e9, 5e10, SIZES)


def numbers(solution):
    patches = (solution.observable(name) for name in ("patches", "patch_largest", "patch_mean"))
    means = (solution.a_r, solution.gap_mean, solution.pressure.max())
    return [*means, solution.g_rms, solution.h_rms, *solution.sizes, *patches]


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("name", FORMATS)
def test_sizes_and_units_of_files(name, unit, tmp_path, plain):
    """A solution from path, load and modulus agrees with that of plain numbers."""
    FORMATS[name](tmp_path / name, unit)
    read = opened(tmp_path / name)
    assert read.n == N
    assert read.unit == "m"
    assert np.allclose(read.sizes, SIZES, rtol=1e-9)
    assert np.allclose(read.rows(0, 12), Z, rtol=1e-6, atol=1e-16)
    assert np.array_equal(read.rows(3, 7), read.rows(0, 12)[3:7])
    assert read.periodic is (True if name in ("z.nc", "z.h5") else None)
    solution = hpc_gfmd.solve(hpc_gfmd.read_surface(tmp_path / name), "1 GPa", "50 GPa")
    assert numbers(solution) == pytest.approx(numbers(plain), rel=1e-6, abs=0)


@pytest.mark.parametrize("name", BARE)
def test_files_of_bare_numbers_need_sizes_and_a_unit(name, tmp_path):
    BARE[name](tmp_path / name, 1e9 * Z)
    named = {"physical_sizes": ("1.2 um", "400 nm")}
    neither_given = r"^surface.physical_sizes: not given, .*; surface.unit: not given"
    for keys, words in (({}, neither_given), (named, r"^surface.unit: not given for the heights")):
        with refused(words):
            hpc_gfmd.read_surface(name, **keys)
    plain = {"physical_sizes": (1200, 400)}
    for keys, scale in ((named | {"unit": "nm"}, 1), (plain | {"unit": "nm"}, 1), (plain, 1e9)):
        read = opened(name, **keys)
        assert read.sizes == pytest.approx([scale * size for size in SIZES], rel=1e-12)
        assert np.allclose(read.rows(0, 12), scale * Z, rtol=1e-12)
        assert read.unit == ("m" if "unit" in keys else "")


def assert_read_under_any_name(name, keys):
    """A file is read under names with other suffixes, and when it is compressed."""
    data = Path(name).read_bytes()
    with zipfile.ZipFile("z.zip", "w") as archive:
        archive.writestr(f"folder/{name}", data)
    others = {f"other{suffix}": data for suffix in SUFFIXES}
    others |= {"z.gz": gzip.compress(data), "z.bz2": bz2.compress(data)}
    others["z.zip"] = Path("z.zip").read_bytes()
    for other_name, content in others.items():
        Path(other_name).write_bytes(content)
        read = opened(other_name, **keys)
        assert np.allclose(read.rows(0, 12), Z, rtol=1e-6, atol=1e-16), (name, other_name)


def test_content_decides_the_format():
    for name, write in FORMATS.items():
        write(name, "nm")
        assert_read_under_any_name(name, {})
    pictures = {"z.tif": lambda path, z: tifffile.imwrite(path, z.T)}
    for name, write in (BARE | pictures).items():
        write(name, 1e9 * Z)
        assert_read_under_any_name(name, BY_HAND)


def test_scene_overrides_sizes_but_not_units(tmp_path):
    FORMATS["z.nc"](tmp_path / "z.nc", "nm")
    read = opened("z.nc", physical_sizes=(10, 20))
    assert read.sizes == pytest.approx((1e-8, 2e-8))
    assert np.allclose(read.rows(0, 12), Z)
    assert opened("z.nc", unit="nm").sizes == pytest.approx(SIZES)
    with refused(r"^surface.unit: found 'um', but .* heights in 'nm', all"):
        opened("z.nc", unit="um")


BAD_METADATA = [
    ({"z": Z, "physical_sizes": [1, 2]}, r"^surface.unit: not given"),
    (
        {"z": Z, "physical_sizes": [1, 2], "unit": "V"},
        r"^surface.unit: in .* 'V' is no unit of length",
    ),
    (
        {"z": Z, "physical_sizes": [1, -2], "unit": "m"},
        r"^surface.physical_sizes: found \[1.0, -2.0\]",
    ),
    ({"a": Z, "b": Z}, r"^surface.dataset: found 'surface', allowed in .*: a, b"),
]


def test_bad_metadata_is_refused():
    for content, words in BAD_METADATA:
        np.savez("z.npz", **content)
        with refused(words):
            hpc_gfmd.read_surface("z.npz")


STEPS = np.round(65535 * (Z - Z.min()) / np.ptp(Z)).astype(np.uint16)


def packed(numbers, **how):
    """Return a function of a path that writes a TIFF which tifffile alone does not unpack."""
    return partial(Image.fromarray(numbers).save, compression="tiff_lzw", **how)


RANGE = {"height_range": [f"{1e9 * z!r} nm" for z in (float(Z.min()), float(Z.max()))]}


@pytest.mark.parametrize(
    ("name", "write", "keys"),
    [
        ("z.tif", lambda p: tifffile.imwrite(p, 1e9 * Z.T), {}),
        ("z.tiff", lambda p: tifffile.imwrite(p, (1e9 * Z.T).astype("f4")), {}),
        ("u.tif", lambda p: tifffile.imwrite(p, STEPS.T), RANGE),
        ("i.tif", lambda p: tifffile.imwrite(p, (STEPS.T - 2.0**15).astype("i2")), RANGE),
        ("u.png", Image.fromarray(STEPS.T).save, RANGE),
        ("l.tif", packed(STEPS.T), RANGE),
        ("l2.tif", packed(STEPS.T ^ 2**15, tiffinfo={339: 2}), RANGE),  # two's complement
        ("l4.tif", packed((65537 * STEPS.T.astype("i8") - 2**31).astype("i4")), RANGE),
        ("lf.tif", packed((1e9 * Z.T).astype("f4")), {}),
    ],
)
def test_images(name, write, keys):
    """x runs to the right and y down; integers are steps of the height range."""
    write(name)
    surface = hpc_gfmd.read_surface(name, boundary="periodic", **BY_HAND, **keys)
    step = np.ptp(Z) / 65535 if keys else 1e-14
    assert np.allclose(surface.heights, Z, rtol=0, atol=0.51 * step)
    without = {"height_range": [0, 1]} if not keys else {}
    with refused(r"surface.height_range = \["):
        hpc_gfmd.read_surface(name, boundary="periodic", **BY_HAND, **without)
    Image.fromarray(np.zeros((4, 4, 3), np.uint8)).save("colours.png")
    with refused(r"found colours \(RGB\), allowed: one number a point"):
        hpc_gfmd.read_surface("colours.png", **BY_HAND)


def test_unknown_formats_are_refused(tmp_path, capfd):
    """The message lists known formats; attempts of other readers print nothing."""
    (tmp_path / "z.abc").write_bytes(b"\x89ABC\r\n\x1a\n" + bytes(range(256)) * 8)
    with refused(r"is not known, or .* known are npy, .*, x3p, .*gwy"):
        opened("z.abc")
    assert not capfd.readouterr().out


def test_uneven_coordinates_are_refused(tmp_path):
    """NetCDF 4 dimensions without coordinates need physical_sizes."""
    netcdf4(tmp_path / "z.nc", "m")
    with h5py.File("z.nc", "r+") as file:
        file["x"][1] *= 1.01  # an inner point
    with refused("not those of a regular grid"):
        opened("z.nc")
    with h5py.File("z.nc", "r+") as file:
        file["x"].attrs["NAME"] = "This is a netCDF dimension but not a netCDF variable.  12"
    with refused("^surface.physical_sizes: not given"):
        hpc_gfmd.read_surface("z.nc")
    assert np.array_equal(opened("z.nc", physical_sizes=SIZES).rows(0, 12), Z)


@pytest.mark.parametrize(
    "keys",
    [
        {},
        {"detrend": "tilt", "boundary": "mirror"},
        {"physical_sizes": ["2.4 um", "0.8 um"], "flip": True},
        {"boundary": "free"},
    ],
)
def test_read_surface_agrees_with_a_scene(keys, tmp_path):
    FORMATS["z.x3p"](tmp_path / "z.x3p", "nm")
    surface = hpc_gfmd.read_surface("z.x3p", **keys)
    assert surface.unit == "m"
    solution = hpc_gfmd.solve(surface, "1 GPa", "50 GPa")
    table = {"kind": "file", "path": "z.x3p"} | keys
    scene = Scene.from_dict(
        {"surface": table, "load": {"pressure": "1 GPa"}, "material": {"E_star": "50 GPa"}}
    )
    results = run_scene(scene, out="out.h5", quiet=True)
    (step,) = results.steps
    assert solution.a_r == step["a_r"]
    assert solution.gap_mean == pytest.approx(step["gap_mean"])
    assert {*results.notes} <= {*solution.notes}  # read_surface looks at the quality, too
    assert solution.note == step["note"]
    with h5py.File("out.h5") as file:
        attributes = file["surface"].attrs
        assert attributes["physical_sizes"] == pytest.approx(surface.sizes)
        assert (attributes["unit"], attributes["pressure_unit"]) == ("m", "Pa")
        ends = "free, free" if keys.get("boundary") == "free" else "periodic, periodic"
        assert attributes["boundary"] == ends  # of the doubled map, if it is mirrored


MASKED = np.ma.masked_greater(Z, 0.9 * Z.max())


@pytest.mark.parametrize(
    ("heights", "keys"),
    [
        (topography("nm"), {}),
        (topography("um").to_unit("nm").detrend("center"), {}),
        (Z, {"physical_sizes": SIZES, "boundary": "periodic"}),
        (1e9 * Z, BY_HAND | {"boundary": "periodic"}),
    ],
)
def test_heights_in_memory(heights, keys, plain):
    """Arrays and Topographies give the same solution; a Topography needs no preparation."""
    surface = hpc_gfmd.prepare_surface(heights, **keys)
    units = ("1 GPa", "50 GPa") if surface.unit else (1e9, 5e10)
    if not keys:
        as_it_is = surface_of_topography(heights, None)
        assert (as_it_is.sizes, as_it_is.unit) == (surface.sizes, surface.unit)
        assert (as_it_is.prepared, as_it_is.free) == (surface.prepared, surface.free)
        assert np.array_equal(as_it_is.heights, surface.heights)
    for argument in [surface] if keys else [surface, heights]:
        assert numbers(hpc_gfmd.solve(argument, *units)) == pytest.approx(numbers(plain), rel=1e-6)


def test_missing_heights_in_memory_and_files():
    """Masked points and nan are refused without surface.fill, for arrays and all formats."""
    surface = hpc_gfmd.prepare_surface(
        surface_topography().Topography(MASKED, SIZES, unit="m"), fill="harmonic", boundary="free"
    )
    assert surface.free == (True, True)
    assert "filled" in surface.prepared[0]
    masked = topography("m", False, MASKED)
    masked.to_netcdf("z.nc")
    masked.to_x3p("z.x3p")
    with_mask = {"z": Z, "mask": MASKED.mask}
    np.savez("z.npz", **with_mask)
    with_fill_value = {"z": MASKED.filled(15 * 2.0**119)}  # NetCDF's
    for name, arrays in (("z.h5", with_mask), ("four.nc", with_fill_value)):
        with h5py.File(name, "w") as file:
            file.update(arrays)
    for name in ("z.nc", "z.x3p", "z.npz", "z.h5", "four.nc"):
        read = opened(name, boundary="free", physical_sizes=SIZES)
        assert np.array_equal(np.isnan(read.rows(0, 12)), MASKED.mask)
        with refused(r"^surface.path: found nan at"):
            hpc_gfmd.read_surface(name, boundary="free", physical_sizes=SIZES)
    np.savez("z.npz", z=Z, mask=MASKED.mask.T)
    with refused("mask"):
        opened("z.npz", physical_sizes=SIZES).rows(0, 12)
    np.savez("z.npz", z=Z, mask=Z)  # the dataset "mask" holds heights
    read = opened("z.npz", physical_sizes=SIZES, dataset="mask")
    assert np.array_equal(read.rows(0, 12), Z)
    with refused("mask .*0 and 1"):
        opened("z.npz", physical_sizes=SIZES, dataset="z").rows(0, 12)
    for heights in (MASKED, MASKED.filled(np.nan)):
        filled = hpc_gfmd.prepare_surface(heights, fill="harmonic", boundary="free")
        assert np.allclose(filled.heights, surface.heights)
        with refused(r"(masked points|found nan at).*prepare_surface\(heights"):
            hpc_gfmd.solve(heights, 1e-9)
        with refused(r"found nan at .* or fill = .harmonic."):
            hpc_gfmd.prepare_surface(heights)
    with refused(r"masked points.*prepare_surface\(heights, fill"):
        hpc_gfmd.solve(topography("m", False, MASKED), "1 GPa", "50 GPa")
    with refused(r"surface.unit: not given"):
        hpc_gfmd.solve(surface_topography().Topography(Z, SIZES), 1e-9)
    with refused(r"surface.unit: found 'nm', but the array has .* in '.m'"):
        hpc_gfmd.prepare_surface(topography("um"), unit="nm")


def test_keys_of_prepared_surfaces(tmp_path):
    FORMATS["z.x3p"](tmp_path / "z.x3p", "nm")
    surface = hpc_gfmd.read_surface("z.x3p", detrend="mean")
    assert np.allclose(surface.heights, Z - Z.mean())
    assert surface.sizes == pytest.approx(SIZES)
    assert surface.prepared == ("mean removed",)
    for key, value in [("physical_sizes", (1, 2)), ("radius", 1.0)]:
        with refused(f"^{key}: found .* beside a surface that is complete, allowed: read_surface"):
            hpc_gfmd.solve(surface, 1.0, **{key: value})
    with refused("^heights: found a PreparedSurface, allowed: an array or a Topography"):
        hpc_gfmd.prepare_surface(surface, refine=2)
    lengths = r"allowed: .* x0 < x1 <= 1200 nm and .* y1 <= 400 nm, plain in this unit"
    nm_map = topography("nm")
    assert hpc_gfmd.prepare_surface(nm_map, crop=(0, 0, 600, 100)).heights.shape == (6, 2)
    with refused(lengths):
        hpc_gfmd.prepare_surface(nm_map, crop=(0, 0, "2 um", "0.4 um"))
    for keys in ({"crop": ("0 um", "0 um", "1 um", "1 um")}, {"radius": "1 mm"}):
        with refused(r"found (1 mm|0 um), allowed: a plain number, as the sizes"):
            hpc_gfmd.prepare_surface(Z, boundary="free", **keys)
    ball = hpc_gfmd.prepare_surface(nm_map, boundary="free", radius="1 mm")
    x, y = (((np.arange(k) + 0.5) / k - 0.5) * L for k, L in zip(N, SIZES))
    form = (x[:, None] ** 2 + y**2) / 2e-3
    assert np.allclose(ball.heights, Z - form, rtol=0, atol=1e-16)
    assert ball.prepared == ("on a form of radius 1 mm",)
    of_array = {"physical_sizes": SIZES, "boundary": "free", "radius": 1e-3}
    loads = [hpc_gfmd.solve(Z, 1e8, 1e10, **of_array), hpc_gfmd.solve(ball, "100 MPa", "10 GPa")]
    assert loads[0].gap_mean == pytest.approx(loads[1].gap_mean)
    with refused(r"surface.detrent: unknown key, nearest: surface.detrend"):
        hpc_gfmd.read_surface("z.x3p", detrent="mean")


def test_packed_pictures_that_cannot_be_read_rightly_are_refused():
    """A mask or inverted grey is not left out without a word when Pillow unpacks the numbers."""
    pages = {"save_all": True, "append_images": [Image.fromarray(STEPS.T)], "tiffinfo": {254: 0}}
    packed(STEPS.T, **pages)("masked.tif")
    packed(STEPS.T)("inverted.tif")
    for name, page, tag, value in (
        ("masked.tif", 1, 254, 4),  # the second page is a mask
        ("inverted.tif", 0, 262, 0),  # 0 stands for white
    ):
        with tifffile.TiffFile(name, mode="r+b") as file:
            file.pages[page].tags[tag].overwrite(value)
    for name, words in (("masked.tif", "does not read its mask"), ("inverted.tif", "0 .* white")):
        with refused(words):
            hpc_gfmd.read_surface(name, boundary="periodic", **BY_HAND, **RANGE)
