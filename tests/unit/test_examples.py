"""Every example runs, on a small grid, without a warning, and leaves its pictures."""

import ast
import re
import runpy
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from mpi_harness import environment

import hpc_gfmd
from hpc_gfmd.util.libraries import surface_topography

FOLDER = Path(__file__).parents[2] / "examples"
SMALL = {"sphere": 48, "wave": 64, "measured": 64, "tfc": 64, "rough_ball": 128}
POINTS = 96  # of the others
MPI = "mpi_script"  # see tests/mpi
ALONE = "measured"  # it imports SurfaceTopography, which initialises MPI: this process must not
EXAMPLES = sorted(FOLDER.glob("*.py"))


def blocks(page):
    return re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)


PAGES = [page for page in sorted(FOLDER.parent.glob("docs/howto/*.md")) if blocks(page)]


def run(path, monkeypatch):
    plt.switch_backend("Agg")
    monkeypatch.setattr(sys, "argv", [str(path), str(SMALL.get(path.stem, POINTS))])
    runpy.run_path(str(path), run_name="__main__")
    plt.close("all")


def alone(tmp_path, script, *arguments):
    """What a script prints that runs in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-W", "error:::__main__", script, *arguments],
        cwd=tmp_path,
        env=environment(MPLBACKEND="Agg"),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_python_of_a_how_to_page(page, tmp_path):
    code = "\n".join(blocks(page))
    surface = hpc_gfmd.make_surface(
        "wave", amplitude="9 nm", n=(8, 6), physical_sizes=("1 um",) * 2
    )
    scan = surface_topography().Topography(surface.heights, surface.sizes, unit="m")
    scan.to_x3p(str(tmp_path / "scan.x3p"))
    (tmp_path / "page.py").write_text(code)
    alone(tmp_path, "page.py")


def test_in_a_process_of_its_own(tmp_path):
    assert "a_r = " in alone(tmp_path, FOLDER / f"{ALONE}.py", str(SMALL[ALONE]))
    for name in ("measured.png", "measured_patches.png", "measured.h5"):
        assert (tmp_path / name).stat().st_size > 10_000


@pytest.mark.parametrize(
    "path", [path for path in EXAMPLES if path.stem not in (MPI, ALONE)], ids=lambda path: path.stem
)
@pytest.mark.filterwarnings("error:::__main__")
def test_example(path, tmp_path, monkeypatch):
    run(path, monkeypatch)
    assert (tmp_path / f"{path.stem}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_is_short_says_what_it_shows_and_has_a_picture(path):
    tree = ast.parse(path.read_text())
    assert sum(isinstance(node, ast.stmt) for node in ast.walk(tree)) <= 30
    assert ast.get_docstring(tree)
    assert (FOLDER.parent / "docs" / "gallery" / f"{path.stem}.png").is_file()
