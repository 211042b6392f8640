"""Small result files for tests: being written, interrupted, complete."""

import numpy as np
import pytest

from hpc_gfmd.output.record import RunFile
from hpc_gfmd.parallel.comm import SerialComm

N = (6, 5)
FIELD = np.arange(30.0).reshape(N)
HEAD = {"scene": "title = 'x'", "identity": "abc", "versions": {"numpy": "2"}, "setup_seconds": 0.1}
SURFACE = {"n": list(N), "physical_sizes": [1.0, 2.0], "h_rms": 0.5, "g_rms": 1.0}
STEP = {
    "p": 0.1,
    "p_star": 0.1,
    "a_r": 0.25,
    "a_r_error": 1e-3,
    "iterations": 7,
    "status": "converged",
}

UNFINISHED = {"p": 0.2, "seconds": 2.5, "iterations": 4, "fft_pairs": 6.5}  # of a load


def begin(path, identity="abc", **how):
    """The file of a run; how: as of RunFile."""
    return RunFile(SerialComm(), path, N, (0, N[0]), HEAD | {"identity": identity}, SURFACE, **how)


def interrupted(path, steps=3, **how):
    """The folder of a run that was interrupted after some loads."""
    with begin(path, **how) as run:
        for index in range(steps):
            run.write_step(index, STEP | {"p": 0.1 * (index + 1)}, {"gap": FIELD + index})
    return run.partial


def complete(path, steps=3, **how):
    """The file of a run that came to its end."""
    interrupted(path, steps, **how)
    with begin(path, **how) as run:
        run.finish("converged")
    return path


def assert_same_steps(found, wanted, rel=0.0):
    """All of the loads that are found, but the time, is as wanted: to the last bit, unless rel, a
    relative tolerance, is given."""
    for index, a, fields in zip(found.indices, found.steps, found.fields, strict=True):
        place = wanted.indices.index(index)
        b = wanted.steps[place]
        others = wanted.fields[place]
        assert a.keys() == b.keys()
        for name in set(a) - {"wall_seconds"}:
            if not rel or isinstance(b[name], str):
                assert a[name] == b[name], name
            elif name in ("a_r", "gap_mean", "energy", "kappa", "p"):
                assert a[name] == pytest.approx(b[name], rel=rel), name
        for name, stored in fields.items():
            x, y = (one.read(0, one.shape[0]) for one in (stored, others[name]))
            assert np.abs(x - y).max() <= rel * y.max(), name


def names(folder):
    """Of the files in a folder."""
    return sorted(path.name for path in folder.iterdir())
