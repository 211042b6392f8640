"""Result files in other programs: xarray, ParaView's reader, and what `export` writes."""

import csv
import os
from pathlib import Path

import numpy as np
import pytest
from result_files import begin

import hpc_gfmd
from hpc_gfmd.contact import all_numbers
from hpc_gfmd.util.libraries import surface_topography

N = (6, 4)
SIZES = (3.0, 1.0)
LOADS = (0.1, 0.25)
SURFACE = {"n": list(N), "physical_sizes": list(SIZES), "h_rms": 0.5}
UNITS = {"unit": "m", "pressure_unit": "Pa"}
HEIGHTS = -np.arange(24.0).reshape(N)


def field(step, name):
    """A field whose numbers encode their step, i and j; the gap has 1000 added."""
    i, j = np.indices(N)
    return (1000.0 * (name == "gap") + 100 * step + 10 * i + j).astype("f4" if step else "f8")


def write(path, loads=LOADS, units=UNITS, **options):
    """Write a result file with numbers of several types and two fields; options: of RunFile."""
    options |= {"about": all_numbers()}
    with begin(path, surface=SURFACE | units, **options) as run:
        run.update(height_field=HEIGHTS)
        for step, p in enumerate(loads):
            attributes = {
                "p": p,
                "a_r": 2 * p,
                "status": "converged",
                "note": "few points" if step else None,
                "patches": [1, 2],
                "gap_mean": 0.5,
                "spanning": step == 0,
                "wall_seconds": 2.0,
                "../evil": 1.0,
            }
            run.write_step(
                step, attributes, {name: field(step, name) for name in ("pressure", "gap")}
            )
        run.finish("converged")
    return path


@pytest.fixture
def path(tmp_path):
    return write(tmp_path / "out.h5")


@pytest.mark.parametrize("compressed", [False, True])
def test_one_step_in_xarray(tmp_path, compressed):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(
        write(tmp_path / "out.h5", units={} if compressed else UNITS, compressed=compressed),
        group="steps/0001",
        engine="h5netcdf",
    ) as step:
        pressure = step.pressure
        assert pressure.dims == ("x", "y")
        assert np.array_equal(pressure, field(1, "pressure"))
        assert np.array_equal(step.x, np.arange(6) * 0.5)
        assert np.array_equal(step.y, np.arange(4) * 0.25)
        assert float(pressure.coords["p"]) == 0.25
        assert np.array_equal(step.heights, HEIGHTS)
        assert step.attrs["a_r"] == 0.5
        assert pressure.attrs["units"] == ("pressure" if compressed else "Pa")
        assert "initial gap" in step.gap.attrs["long_name"]
        for name in (*step.data_vars, *step.coords):
            assert step[name].attrs["units"]
            assert step[name].attrs["long_name"]


def test_all_steps_in_xarray(path):
    """The root holds the numbers of all loads, as in `Solutions`, and steps hold fields."""
    xarray = pytest.importorskip("xarray")
    solutions = hpc_gfmd.load(path)
    with xarray.open_dataset(path) as dataset, solutions.to_xarray() as whole:
        assert np.array_equal(dataset["load"], LOADS)
        assert dataset.a_r.dims == ("load",)
        assert (dataset.p.attrs["units"], whole.p.attrs["units"]) == ("Pa", "Pa")
        assert whole.drop_vars(["pressure", "gap", "heights"]).equals(dataset)
        assert list(dataset.spanning.values) == [True, False]
        assert np.array_equal(whole.gap, [field(0, "gap"), field(1, "gap")])
        assert (whole.gap.dims, whole.heights.dims) == (("load", "x", "y"), ("x", "y"))
    table = solutions.to_dataframe()
    assert (list(table.a_r), list(table.spanning)) == ([0.2, 0.5], [True, False])
    assert (table.attrs["units"]["p"], table.attrs["units"]["a_r"]) == ("Pa", "1")
    with xarray.open_datatree(path, engine="h5netcdf") as tree:
        assert list(tree["steps"].children) == ["0000", "0001"]
        assert np.array_equal(tree["steps/0000/gap"], field(0, "gap"))
        assert np.array_equal(tree["load"], LOADS)
        assert not [name for group in tree.subtree for name in group.dims if "phony" in str(name)]


def read_by_vtk(path, step):
    """(image, {name: array over x and y}, times) that vtkHDFReader reads at a step."""
    reader = pytest.importorskip("vtkmodules.vtkIOHDF").vtkHDFReader()
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

    reader.SetFileName(str(path))
    assert reader.CanReadFile(str(path))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    reader.SetStep(step)
    reader.Update()
    image = reader.GetOutput()
    arrays = {}
    points = np.array([image.GetPoint(k) for k in range(image.GetNumberOfPoints())])
    i = np.rint(points[:, 0] / 0.5).astype(int)
    j = np.rint(points[:, 1] / 0.25).astype(int)
    for k in range(image.GetPointData().GetNumberOfArrays()):
        array = image.GetPointData().GetArray(k)
        arrays[array.GetName()] = np.full(N, np.nan)
        arrays[array.GetName()][i, j] = vtk_to_numpy(array)
    return image, arrays, times


def test_paraview_reads_numbers_at_their_positions(path):
    for step in (0, 1):
        image, arrays, times = read_by_vtk(path, step)
        assert times == LOADS
        assert image.GetOrigin() == (0, 0, 0)
        assert image.GetBounds() == (0, 2.5, 0, 0.75, 0, 0)
        assert sorted(image.GetSpacing()) == [0.25, 0.5, 1]
        assert np.array_equal(arrays.pop("heights"), HEIGHTS)
        assert set(arrays) == {"pressure", "gap"}
        for name, array in arrays.items():
            assert np.array_equal(array, field(step, name))


def test_csv(path, cli):
    assert cli.prints("export out.h5 --to csv") == "out.csv\n"
    lines = list(csv.DictReader(path.with_suffix(".csv").read_text().splitlines()))
    assert [(line["step"], float(line["a_r"]), line["note"]) for line in lines] == [
        ("0", 0.2, ""),
        ("1", 0.5, "few points"),
    ]
    assert {"p [Pa]", "gap_mean [m]", "wall_seconds [s]"} < set(lines[0])


def test_channels_of_gwyddion(path, cli):
    """Gaps and heights are topographies with units; pressures, in Pa, are stored, too."""
    reader = surface_topography().open_topography(cli.prints("export out.h5 --to gwy").strip())
    assert [c.name for c in reader.channels] == ["gap, load 0", "heights, load 0", "gap, load 1"]
    gap = reader.topography(channel_index=2)
    assert np.array_equal(gap.heights(), field(1, "gap"))
    assert (gap.physical_sizes, gap.unit) == (SIZES, "m")
    written = path.with_suffix(".gwy").read_bytes()
    assert b"unitstr\0sPa\0" in written
    assert field(1, "pressure").T.astype("<f8").tobytes() in written
    hpc_gfmd.load(path)[1].export("gap.gwy", ["gap"])
    assert b"pressure" not in Path("gap.gwy").read_bytes()
    assert "found 7, allowed: 0, 1" in cli.refused("export out.h5 --to gwy --step 7")


def test_the_table_that_a_result_was_made_of_is_not_replaced(path, cli):
    """Scene, result and a table of a spectrum often have the same name but for its end."""
    mine = path.with_suffix(".csv")
    mine.write_text("q,C")
    assert "which exists" in cli.refused("export out.h5 --to csv")
    assert "which exists" in cli.refused(f"export out.h5 --to csv -o {mine}")
    assert mine.read_text() == "q,C"
    assert cli.prints("export out.h5 --to csv --force") == "out.csv\n"
    assert mine.read_text() != "q,C"


def test_suffixes_of_other_formats_are_refused(path, tmp_path, cli):
    for options in ("gwy -o z.csv", "csv -o z.gwy", "csv -o z.GWY", "csv -o z.h5", "gwy -o z.nc"):
        to = options[:3]
        message = cli.refused(f"export out.h5 --to {options} --force")
        assert f"with --to {to}, allowed: a .{to} file" in message
    assert os.listdir(tmp_path) == ["out.h5"]
    assert cli.prints("export out.h5 --to csv -o z.txt") == "z.txt\n"


def test_refused_exports_write_nothing(path, tmp_path, cli):
    for options in ("csv -o out.h5", "csv -o missing/a.csv", "pdf"):
        cli.refused(f"export out.h5 --to {options}")
    assert os.listdir(tmp_path) == ["out.h5"]
