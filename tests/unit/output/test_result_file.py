"""The result file of one process: attributes and copies. Round trips on any number
of ranks are in tests/mpi/test_result_file.py."""

import h5py
import numpy as np
from result_files import STEP, SURFACE, begin, complete

from hpc_gfmd.output.read import read_result


def test_attributes_survive_a_round_trip(path):
    attributes = {"p": 1, "flag": True, "text": "mu \u03bc", "words": ["a", "b"]}
    attributes |= {"list": [1.0, 2.0], "numpy": np.float32(0.5)}
    with begin(path) as run:
        run.write_step(0, attributes | {"nothing": None, "nan": np.nan, "escape": "a\x1b[31m\nb"})
        run.finish("x")
    (read,) = read_result(path).steps
    assert read.pop("escape").isprintable()
    assert np.isnan(read.pop("nan"))
    assert read == attributes
    assert type(read["flag"]) is bool


def test_copies_made_by_h5py_are_read(path, tmp_path):
    complete(path, 1)
    copy = tmp_path / "copy.h5"
    with h5py.File(path) as old, h5py.File(copy, "w") as new:
        new.attrs.update(old.attrs)
        old.copy("surface", new)
        old.copy("steps", new)
    copied = read_result(copy)
    assert (copied.steps, copied.surface) == ([STEP], SURFACE)
