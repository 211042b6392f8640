"""The result file of one process: attributes, copies and damaged fields. Round trips on any number
of ranks are in tests/mpi/test_result_file.py."""

import h5py
import numpy as np
from refusal import refused
from result_files import FIELD, STEP, SURFACE, begin, complete, names

from hpc_gfmd import load
from hpc_gfmd.output.read import read_result
from hpc_gfmd.util.errors import GfmdError


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


def test_damaged_fields_are_not_read_copied_drawn_or_exported(path, tmp_path, cli):
    """A copy would get a new checksum, which would hide the damage."""
    content = bytearray(complete(path, 1).read_bytes())
    content[content.index(FIELD.tobytes()) + 13] ^= 1
    path.write_bytes(content)
    stored = read_result(path).fields[0]["gap"]
    damaged = "the numbers of steps/0000/gap are damaged"
    for _ in range(2):
        # parts of the field, whose checksum covers the whole, are read without a check
        assert np.array_equal(stored.read(3, 6), FIELD[3:])
        for start in (0, 2):
            assert stored.read(start, start + 2).shape == (2, 5)
        with refused(damaged, GfmdError):
            stored.read(4, 6)
    with refused(damaged, GfmdError):
        load(path).save("copy.h5")
    for command in ("plot out.h5", "export out.h5 --to gwy"):
        assert damaged in cli.refused(command, code=1)
    assert names(tmp_path) == ["out.h5"]
