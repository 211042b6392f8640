"""Small result files for tests: running, interrupted and complete ones."""

import re
from pathlib import Path

import numpy as np
import pytest

import hpc_gfmd
from hpc_gfmd.output.record import RunFile
from hpc_gfmd.parallel.comm import SerialComm

N = (6, 5)
FIELD = np.arange(30.0).reshape(N)
SCENE = Path(hpc_gfmd.__file__).parent / "scenes" / "wave.toml"
HEAD = {
    "scene": SCENE.read_text(),
    "identity": "abc",
    "versions": {"numpy": "2"},
    "setup_seconds": 0.1,
}
SURFACE = {"n": list(N), "physical_sizes": [1.0, 2.0], "h_rms": 0.5, "g_rms": 1.0}
STEP = {
    "p": 0.1,
    "p_star": 0.1,
    "a_r": 0.25,
    "a_r_error": 1e-3,
    "iterations": 7,
    "status": "converged",
}

UNFINISHED = {  # attributes of a load
    "p": 0.2,
    "seconds": 2.5,
    "iterations": 4,
    "fft_pairs": 6.5,
    "on_coarser_grids": [0.2, 1.0],
}


def begin(path, identity="abc", surface=SURFACE, head=HEAD, **options):
    """The RunFile of a new or interrupted run; options: of RunFile."""
    n = tuple(surface["n"])
    head = head | {"identity": identity}
    return RunFile(SerialComm(), path, n, (0, n[0]), head, surface, **options)


def interrupted(path, steps=3, **options):
    """The folder of a run that was interrupted after `steps` loads."""
    with begin(path, **options) as run:
        for index in range(steps):
            run.write_step(index, STEP | {"p": 0.1 * (index + 1)}, {"gap": FIELD + index})
    return run.partial


def complete(path, steps=3, **options):
    """The file of a finished run of `steps` loads."""
    interrupted(path, steps, **options)
    with begin(path, **options) as run:
        run.finish("converged")
    return path


def assert_same_steps(result, wanted, rel=0.0):
    """Compare attributes, but times, and fields of a result with those of a reference result.

    rel: relative tolerance of numbers and fields; 0 compares all to the last bit.
    """
    for index, attributes, fields in zip(result.indices, result.steps, result.fields, strict=True):
        position = wanted.indices.index(index)
        wanted_attributes = wanted.steps[position]
        wanted_fields = wanted.fields[position]
        assert attributes.keys() == wanted_attributes.keys()
        for name in set(attributes) - {"wall_seconds"}:
            if rel and name == "note":  # may say how large rounding errors are
                assert _without_digits(attributes[name]) == _without_digits(wanted_attributes[name])
            elif not rel or isinstance(wanted_attributes[name], str):
                assert attributes[name] == wanted_attributes[name], name
            elif name in ("a_r", "gap_mean", "energy", "kappa", "p"):
                assert attributes[name] == pytest.approx(wanted_attributes[name], rel=rel), name
        for name, stored in fields.items():
            field = stored.read(0, stored.shape[0])
            wanted_field = wanted_fields[name].read(0, stored.shape[0])
            assert np.abs(field - wanted_field).max() <= rel * wanted_field.max(), name


def names(folder):
    """Sorted names of the files in a folder."""
    return sorted(path.name for path in folder.iterdir())


def _without_digits(text):
    return re.sub(r"\d+", "", text)
