"""The result file on one process: what it holds, and what is refused as one."""

import h5py
import numpy as np
from refusal import refused
from result_files import FIELD, STEP, SURFACE, begin, complete, names

from hpc_gfmd import load
from hpc_gfmd.output.read import read_result
from hpc_gfmd.util.errors import GfmdError


def test_a_finished_file_holds_everything(path):
    complete(path, 1)
    result = read_result(path)
    assert (result.status, result.scene_toml, result.head["versions"]) == (
        "converged",
        "title = 'x'",
        '{"numpy": "2"}',
    )
    assert result.surface == SURFACE
    assert result.steps == [STEP]
    assert result.head["format"] == "hpc-gfmd"
    assert result.head["start_time"] <= result.head["end_time"]
    assert np.array_equal(result.fields[0]["gap"].read(2, 4), FIELD[2:4])
    assert names(path.parent) == ["out.h5"]


def test_attributes_of_all_kinds_survive(path):
    known = {"p": 1, "flag": True, "text": "mu \u03bc", "words": ["a", "b"]}
    known |= {"list": [1.0, 2.0], "numpy": np.float32(0.5)}
    with begin(path) as run:
        run.write_step(0, known | {"nothing": None, "nan": np.nan, "escape": "a\x1b[31m\nb"})
        run.finish("x")
    (found,) = read_result(path).steps
    assert found.pop("escape").isprintable()
    assert np.isnan(found.pop("nan"))
    assert found == known
    assert type(found["flag"]) is bool


def test_copies_made_by_h5py_are_read(path, tmp_path):
    complete(path, 1)
    copy = tmp_path / "copy.h5"
    with h5py.File(path) as old, h5py.File(copy, "w") as new:
        new.attrs.update(old.attrs)
        old.copy("surface", new)
        old.copy("steps", new)
    assert read_result(copy).steps == [STEP]


def test_a_damaged_field_is_neither_read_nor_copied_nor_drawn(path, tmp_path, cli):
    """Nobody would notice in the copy, which has a checksum of its own."""
    content = bytearray(complete(path, 1).read_bytes())
    content[content.index(FIELD.tobytes()) + 13] ^= 1
    path.write_bytes(content)
    stored = read_result(path).fields[0]["gap"]
    damaged = "the numbers of steps/0000/gap are damaged"
    for _ in range(2):
        # not all of them, so that nobody can tell
        assert np.array_equal(stored.read(3, 6), FIELD[3:])
        for start in (0, 2):
            assert stored.read(start, start + 2).shape == (2, 5)
        with refused(damaged, GfmdError):
            stored.read(4, 6)
    with refused(damaged, GfmdError):
        load(path).save("copy.h5")
    assert not (tmp_path / "copy.h5").exists()
    assert damaged in cli.refused("plot out.h5", code=1)
