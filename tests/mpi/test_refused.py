"""Bad scenes on any number of ranks: exit code 2, a single line on stderr, no files, no hang."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from scene_tables import rows

pytestmark = pytest.mark.mpi
GOOD = """
surface = {kind = "wave", amplitude = 0.1, n = [8, 8]}
load.pressure = 0.1
"""
BAD = rows("""
load.presure=1 | pressure
solver.options={bogus = 1} | bogus
output.path=missing/a.h5 | output.path: the folder missing does not exist
machine.threads=65536 | machine.threads
surface.n=[1048576, 1048576] | GiB
surface.amplitude=0 ; load={p_star = [0.1]} | load.p_star
output={dtype = "single", fields = ["pressure"]} ; material.E_star=1e-50 ; load={p_star = 0.1} | output.dtype
material.E_star=1e-100 ; surface.amplitude=1e-90 ; surface.physical_sizes=[1e90, 1e90] | E_star*g_rms
surface={kind = "file", physical_sizes = [1, 1], path = "none.npy"} | none.npy
surface={kind = "file", physical_sizes = [1, 1], path = "text.npy"} | text.npy
surface={kind = "file", physical_sizes = [1, 1], path = "nan.npy"} | nan
surface={kind = "file", physical_sizes = [1, 1], path = "missing.npy"} | (8, 7)
surface={kind = "file", physical_sizes = [1, 1], path = "both.npy"} | surface.path
surface={kind = "file", physical_sizes = [1, 1], path = "complex.npy"} | complex
surface={kind = "file", physical_sizes = [1, 1], path = "z.h5", dataset = "q"} | height
surface={kind = "file", physical_sizes = [1, 1], path = "flat.npy"} ; load={p_star = 0.1} | load.p_star
""")  # noqa: E501


@pytest.fixture
def scene(comm, shared_path):
    """Write a scene and several bad height maps to the current folder."""
    if comm.rank == 0:
        Path("scene.toml").write_text(GOOD)
        Path("text.npy").write_text("no heights")
        z = np.zeros((9, 8))
        np.save("flat.npy", z)
        np.save("complex.npy", z + 1j)
        z[-1, -1] = 1.7e308
        np.save("missing.npy", z)
        z[0, 0] = -1.7e308
        np.save("both.npy", z)
        z[-1, -1] = np.nan
        z[0, 0] = 0.0
        np.save("nan.npy", z)
        with h5py.File("z.h5", "w") as file:
            file["height"] = z
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
