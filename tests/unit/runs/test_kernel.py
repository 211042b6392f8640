"""Output of a real notebook kernel: pictures, progress, and messages about missing packages."""

import configparser
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from hpc_gfmd.util.errors import EXTRAS

START = """
import sys, warnings
import numpy as np
import hpc_gfmd
warnings.simplefilter("error")
# of pyparsing, when an older Matplotlib calls it
warnings.filterwarnings("ignore", category=DeprecationWarning, module="matplotlib|pyparsing")
wall = np.add.outer(np.arange(8) % 3, np.arange(8) % 2) * 0.01
sweep = hpc_gfmd.solve(wall, p_star=[0.1, 0.2])
"""
# {source of a cell: number of pictures shown}
PICTURES = {
    "sweep.plot('a_r')": 1,
    "for _ in range(2):\n    sweep.plot('a_r')": 2,
    "sweep.plot('a_r'); sweep[0].plot('pressure')\n1": 2,
    "fig = sweep.plot('a_r')\nfig": 1,
    "fig": 1,
    "[sweep.plot('a_r'), sweep.plot('kappa')]": 2,
    "hpc_gfmd.make_surface('wave', n=(8, 8), amplitude=0.01).plot()": 1,
    "sweep.plot('a_r')\nimport matplotlib.pyplot as plt\nplt.show()": 1,
    "len(plt.get_fignums())": 0,
}
WITH_BAR = "hpc_gfmd.solve(wall, p_star=0.1, progress=True).status"
# as if these packages were missing
HIDE = """
from hpc_gfmd.runs import progress
progress.find_spec = lambda name: None
sys.modules["xarray"] = None
"""
MANY = "[s.status for s in hpc_gfmd.solve_many([wall] * 2, 0.1, processes=1, progress=True)]"
CELLS = [START, *PICTURES, WITH_BAR, HIDE, WITH_BAR, MANY, "sweep.to_xarray()"]


@pytest.fixture(scope="module")
def outputs():
    """The outputs of each cell of a notebook."""
    notebook = nbformat.v4.new_notebook(cells=list(map(nbformat.v4.new_code_cell, CELLS)))
    NotebookClient(notebook, kernel_name="python3", allow_errors=True).execute()
    return [cell.outputs for cell in notebook.cells]


def text(outputs, stream):
    """The text of a cell on a stream."""
    return "".join(o.text for o in outputs if o.output_type == "stream" and o.name == stream)


def test_every_picture_is_shown_once(outputs):
    assert not any(output.output_type == "error" for output in outputs[0])
    shown = [
        sum("image/png" in output.get("data", {}) for output in cell_outputs)
        for cell_outputs in outputs[1 : len(PICTURES) + 1]
    ]
    assert shown == list(PICTURES.values())
    assert outputs[len(PICTURES)][0].data["text/plain"] == "0"


def test_progress_is_a_widget_or_a_line_of_output(outputs):
    widget, _, line, many, _ = outputs[len(PICTURES) + 1 :]
    assert any("application/vnd.jupyter.widget-view+json" in o.get("data", {}) for o in widget)
    assert "load 1/1" in text(line, "stdout")
    assert "(wanted 1e-03)" in text(line, "stdout")
    assert "surfaces:" in text(many, "stdout")
    assert "/2 [" in text(many, "stdout")
    for cell_outputs in widget, line, many:
        assert not text(cell_outputs, "stderr")


def test_missing_packages_name_their_extra(outputs):
    (error,) = outputs[-1]
    assert error.ename == "GfmdError"
    assert "pip install 'hpc-gfmd[notebook]'" in error.evalue


def test_extras_install_the_packages_that_messages_name():
    config = configparser.ConfigParser()
    config.read(Path(__file__).parents[3] / "setup.cfg")
    extras = config["options.extras_require"]
    for package, extra in EXTRAS.items():
        assert f"{package.replace('_', '-')}>=" in extras[extra]
