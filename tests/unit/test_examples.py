"""Every example runs, on a small grid, without a warning, and leaves its pictures."""

import ast
import runpy
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from mpi_harness import environment

FOLDER = Path(__file__).parents[2] / "examples"
SMALL = {"sphere": 48, "wave": 64, "measured": 64, "tfc": 64}
POINTS = 96  # of the others
MPI = "mpi_script"  # see tests/mpi
ALONE = "measured"  # it imports SurfaceTopography, which initialises MPI: this process must not
EXAMPLES = sorted(FOLDER.glob("*.py"))


def run(path, monkeypatch):
    plt.switch_backend("Agg")
    monkeypatch.setattr(sys, "argv", [str(path), str(SMALL.get(path.stem, POINTS))])
    runpy.run_path(str(path), run_name="__main__")
    plt.close("all")


def test_in_a_process_of_its_own(tmp_path):
    arguments = [
        sys.executable,
        "-W",
        "error:::__main__",
        FOLDER / f"{ALONE}.py",
        str(SMALL[ALONE]),
    ]
    done = subprocess.run(
        arguments, cwd=tmp_path, env=environment(MPLBACKEND="Agg"), capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "a_r = " in done.stdout
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
