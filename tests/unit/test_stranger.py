"""The examples of the README with a measured surface: from an instrument's file to results."""

import re
from pathlib import Path

import numpy as np
import pytest
from contacts import rough
from matplotlib.text import Text
from mpi_harness import printed

import hpc_gfmd
from hpc_gfmd.output.summary import estimate
from hpc_gfmd.util.libraries import surface_topography

SIZE = 12e-6  # m
README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
PYTHON, TOML = (
    re.search(f"```{language}\n(.*?)```", README, re.DOTALL)[1] for language in ("python", "toml")
)
LOAD = "20 MPa"
MODULUS = "2 GPa"  # as in the README


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with scan.x3p, a tilted and not periodic part of a rough surface."""
    folder = tmp_path_factory.mktemp("stranger")
    shape = rough((2, 16, 4), seed=3, g_rms=0.1, physical_sizes=(2 * SIZE, 2 * SIZE))
    wall = hpc_gfmd.make_surface(**shape)
    heights = wall.heights[:64, :64] + 1e-7 * np.arange(64)[:, None]
    surface_topography().Topography(1e9 * heights, (1e9 * SIZE, 1e9 * SIZE), unit="nm").to_x3p(
        str(folder / "scan.x3p")
    )
    return folder


@pytest.mark.slow
def test_python_example(folder):
    (folder / "six.py").write_text(PYTHON)
    (output_line,) = printed("six.py", cwd=folder).splitlines()
    scan = hpc_gfmd.read_surface(folder / "scan.x3p", detrend="tilt", boundary="mirror")
    solution = hpc_gfmd.solve(scan, LOAD, MODULUS)
    area = float(re.fullmatch(r"a_r = ([\d.]+) %", output_line)[1]) / 100
    assert area == pytest.approx(solution.a_r_corrected, rel=1e-2)
    assert 0.01 < area < 0.5
    assert (folder / "pressure.png").read_bytes().startswith(b"\x89PNG")
    texts = [text.get_text() for text in solution.plot("pressure").findobj(Text)]
    assert any("(MPa)" in text for text in texts)
    assert {"$x$ (µm)", "$y$ (µm)"} <= set(texts)


@pytest.mark.slow
def test_scene_example(folder):
    (folder / "scene.toml").write_text(TOML)
    output = printed("-m", "hpc_gfmd", "run", "scene.toml", cwd=folder)
    plotted = printed("-m", "hpc_gfmd", "plot", "contact.h5", cwd=folder)
    pictures = re.findall(r"^\S+\.png$", plotted, re.M)
    assert len(pictures) == 2
    assert all((folder / name).is_file() for name in pictures)
    (solution,) = hpc_gfmd.load(folder / "contact.h5")
    (step,) = solution.result.steps
    assert estimate(100 * solution.a_r_corrected, "a_r_corrected", step) in output
    assert "[MPa]" in output
    python = hpc_gfmd.solve(
        hpc_gfmd.read_surface(folder / "scan.x3p", detrend="tilt", boundary="mirror"), LOAD, MODULUS
    )
    assert solution.status == "converged"
    assert solution.a_r == pytest.approx(python.a_r, rel=1e-2)
    sizes = solution.distributions["patches"]
    assert 0 < sizes["edges"][0] <= sizes["edges"][-1] < SIZE**2
    assert np.diff(sizes["edges"]) @ sizes["density"] == pytest.approx(1)


SCRIPT = """
import hpc_gfmd, numpy as np
from SurfaceTopography import Topography, open_topography
results = {}
for name in ("new", "worn"):
    scan = open_topography(f"{name}.nc").topography().detrend("mad-tilt")
    out = abs(scan.heights() - scan.median()) > 5 * scan.mad_height()
    whole = np.ma.masked_where(out, scan.heights())
    scan = Topography(whole, scan.physical_sizes, unit=scan.unit).interpolate_undefined_data()
    results[name] = hpc_gfmd.solve(scan, ["5 MPa", "20 MPa"], "2 GPa", boundary="free")
results["new"].to_dataframe().to_csv("numbers.csv")
hpc_gfmd.plot(results, "a_r").savefig("both.png")
results["new"].export("pressure.gwy", fields=["pressure"])
"""


@pytest.mark.slow
def test_script_for_scans_with_outliers_and_holes(folder):
    """A pipeline of SurfaceTopography, a sweep, a table, a plot of two samples and a GWY file;
    units are only needed for load and modulus."""
    assert len(SCRIPT.strip().splitlines()) <= 12
    scan = hpc_gfmd.read_surface(folder / "scan.x3p", detrend="tilt", boundary="free")
    for name, scale in (("new", 1), ("worn", 0.5)):
        z = np.ma.array(1e9 * scale * scan.heights + 10 * np.arange(64), mask=False)
        z[5, 7] += 1e5
        z[20:23, 30] = np.ma.masked
        surface_topography().Topography(z, (1e9 * SIZE,) * 2, unit="nm").to_netcdf(
            str(folder / f"{name}.nc")
        )
    (folder / "twelve.py").write_text(SCRIPT)
    printed("twelve.py", cwd=folder)
    table = np.genfromtxt(folder / "numbers.csv", delimiter=",", names=True)
    wanted = hpc_gfmd.solve(scan, ["5 MPa", "20 MPa"], "2 GPa")
    assert table["p"] == pytest.approx([5e6, 20e6])
    assert table["a_r"] == pytest.approx([solution.a_r for solution in wanted], rel=0.1)
    assert (folder / "both.png").read_bytes().startswith(b"\x89PNG")
    written = (folder / "pressure.gwy").read_bytes()
    assert written.count(b"GwyDataField") == 2
    assert b"unitstr\0sPa\0" in written
