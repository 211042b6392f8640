"""A programming error is shown as one, an error of the user's in one line."""

import numpy as np
import pytest
from faults.seeds import seeds

from hpc_gfmd.output import read
from hpc_gfmd.scene import File
from hpc_gfmd.surface import files
from hpc_gfmd.surface.topography import open_topography


def test_in_the_reader_of_results(tmp_path, monkeypatch, cli):
    path = seeds("result", tmp_path)[0]
    monkeypatch.setattr(read, "inside", None)
    shown = cli("show", path)
    assert shown.code == 1
    assert all(words in shown.err for words in ("Traceback", "internal error: TypeError"))


def test_in_the_reader_of_maps(tmp_path, monkeypatch):
    np.save(tmp_path / "z.npy", np.eye(4))
    monkeypatch.setattr(files, "require_map", None)
    with pytest.raises(TypeError):
        open_topography(File(kind="file", path=str(tmp_path / "z.npy"), physical_sizes=(1, 1)))
