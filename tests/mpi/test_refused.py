"""Bad scenes on any number of ranks: exit code 2, a single line on stderr, no files, no hang."""

from pathlib import Path

import numpy as np
import pytest
from contacts import WAVE_SCENE
from scene_tables import rows

pytestmark = [pytest.mark.mpi, pytest.mark.two_ranks]
BAD = rows("""
load.presure=1 | pressure
output.path=missing/a.h5 | output.path: the folder missing does not exist
surface.n=[1048576, 1048576] | GiB
output={dtype = "single", fields = ["pressure"]} ; material.E_star=1e-50 ; load={p_star = 0.1} | output.dtype
surface={kind = "file", physical_sizes = [1, 1], path = "none.npy"} | none.npy
surface={kind = "file", physical_sizes = [1, 1], path = "nan.npy"} | nan
surface={kind = "file", physical_sizes = [1, 1], path = "missing.npy"} | (8, 7)
""")  # noqa: E501


@pytest.fixture
def scene(comm, shared_path):
    """Write a scene and several bad height maps to the current folder."""
    if comm.rank == 0:
        Path("scene.toml").write_text(WAVE_SCENE)
        z = np.zeros((9, 8))
        z[-1, -1] = 1.7e308
        np.save("missing.npy", z)
        z[-1, -1] = np.nan
        np.save("nan.npy", z)
    comm.barrier()
    return "scene.toml"


@pytest.mark.parametrize(("overrides", "named"), [*BAD, (None, "gone.toml")])
def test_refused(comm, scene, overrides, named, cli):
    before = sorted(Path.cwd().iterdir())
    comm.barrier()
    words = []
    for override in overrides.split(" ; ") if overrides else ():
        words += ["--set", override]
    outcome = cli("run", scene if overrides else "gone.toml", *words)
    assert outcome.code == 2
    assert outcome.err.count("\n") == (comm.rank == 0)
    assert comm.rank > 0 or named in outcome.err
    comm.barrier()
    assert sorted(Path.cwd().iterdir()) == before


def test_commands_of_one_process_work_once(comm, scene, cli):
    """They print and write on rank 0; an error reaches every rank."""
    outcome = cli("run", scene, "-o", "once.h5")
    assert outcome.code == 0, outcome.err
    for number in range(2):
        outcome = cli("export", "once.h5", "--to", "gwy", "-o", "once.gwy")
        assert outcome.code == 2 * number
        assert comm.rank == 0 or not outcome.out + outcome.err
        assert comm.rank > 0 or ("exists" in outcome.err) == (number == 1)
    outcome = cli("show", "once.h5", "--json")
    assert outcome.code == 0
    assert outcome.out.count('"surface": {') == (comm.rank == 0)
