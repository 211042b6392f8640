"""Examples run on small grids without warnings and save their pictures."""

import runpy
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import nbformat
import numpy as np
import pytest
from mpi_harness import printed
from nbclient import NotebookClient
from scipy import ndimage

FOLDER = Path(__file__).parents[2] / "examples"
SMALL = {"sphere": 48, "wave": 64, "measured": 64, "tfc": 64, "rough_ball": 128, "creep": 256}
POINTS = 96  # along an axis of all other examples
MPI = "mpi_script"  # see tests/mpi
OPTIONAL = "leak_map"  # needs reynoldsflow
ALONE = "measured"  # in a new process, since SurfaceTopography initialises MPI
EXAMPLES = sorted(FOLDER.glob("*.py"))
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def run(path, monkeypatch):
    """Global variables of an example after it ran on a small grid."""
    plt.switch_backend("Agg")
    monkeypatch.setattr(sys, "argv", [str(path), str(SMALL.get(path.stem, POINTS))])
    variables = runpy.run_path(str(path), run_name="__main__")
    plt.close("all")
    return variables


@pytest.mark.slow
def test_example_with_surface_topography(tmp_path):
    script = FOLDER / f"{ALONE}.py"
    assert "a_r = " in printed("-W", "error:::__main__", script, SMALL[ALONE], MPLBACKEND="Agg")
    for name in ("measured.png", "measured_patches.png", "measured.h5"):
        assert (tmp_path / name).stat().st_size > 10_000


@pytest.mark.parametrize("path", [path for path in EXAMPLES if path.stem not in (MPI, ALONE)])
@pytest.mark.filterwarnings("error:::__main__")
def test_example(path, tmp_path, monkeypatch):
    if path.stem == OPTIONAL:
        pytest.importorskip("reynoldsflow")
    variables = run(path, monkeypatch)
    assert (tmp_path / f"{path.stem}.png").read_bytes().startswith(b"\x89PNG")
    if path.stem == "leak":
        check_flow(variables["flow"])


def check_flow(flow):
    """Flow through layers in series and in parallel and a wall; Keller's identity.

    The flow along x times that along y through the inverse gap is 1, with mirrored sides.
    """
    rng = np.random.default_rng(1)
    gap = np.tile(1 + rng.random((24, 1)), 24)
    assert flow(gap) == pytest.approx(24 / (gap[:, 0] ** -3).sum())
    assert flow(gap.T) == pytest.approx((gap[:, 0] ** 3).sum() / 24)
    assert flow(np.where(np.arange(24)[:, None] == 7, 0.0, gap)) == 0
    rough = np.exp(ndimage.gaussian_filter(rng.standard_normal((64, 64)), 4, mode="mirror"))
    along_x, along_y = (flow(np.hstack([g, g[:, ::-1]])) / 2 for g in (rough, 1 / rough.T))
    assert along_x * along_y == pytest.approx(1, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(path):
    """It runs from a clean start, shows a picture in every cell that draws one, and warns of
    nothing; it is kept without outputs."""
    notebook = nbformat.read(path, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in cells)
    NotebookClient(notebook, kernel_name="python3", timeout=600).execute()
    for cell in cells:
        shown = sum("image/png" in output.get("data", {}) for output in cell.outputs)
        assert shown == ("plot(" in cell.source or "plt." in cell.source), cell.source
        printed = "".join(o.text for o in cell.outputs if o.get("name") == "stderr")
        assert all(line.startswith("compil") for line in printed.splitlines()), printed
