"""Missing parts of the installation: they are not needed, or one line names what to install."""

import pytest
from contacts import WAVE_SCENE
from mpi_harness import call, environment, missing, printed
from scene_tables import rows

SCENE = WAVE_SCENE


def without(folder, *modules):
    """Return an environment in which Python cannot import some modules."""
    for module in modules:
        (folder / "gone").mkdir(exist_ok=True)
        text = f"raise ModuleNotFoundError({f'No module named {module}'!r}, name={module!r})\n"
        (folder / "gone" / f"{module}.py").write_text(text)
    env = environment()
    return env | {"PYTHONPATH": f"{folder / 'gone'}:{env['PYTHONPATH']}"}


@pytest.mark.skipif(missing() != "", reason="needs an MPI launcher")
def test_mpirun_without_mpi4py(folder):
    run = call(2, ["run", "scene.toml"], env=without(folder, "mpi4py"), cwd=folder)
    line = run.stderr.strip()
    assert run.returncode == 1, run.stderr
    assert line.count("\n") == 0
    assert all(word in line for word in ("2 ranks", "mpi4py", "hpc-gfmd[mpi]"))
    assert sorted(p.name for p in folder.iterdir()) == ["gone", "scene.toml"]


@pytest.mark.skipif(missing() != "", reason="needs an MPI launcher")
def test_a_bad_scene_by_mpirun(folder):
    """As a user and a job script see it."""
    run = call(2, ["run", "scene.toml", "--set", "surface.perids=[3, 3]"], cwd=folder)
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr.strip().count("\n") == 0
    assert "surface.periods" in run.stderr
    assert [path.name for path in folder.iterdir()] == ["scene.toml"]


@pytest.mark.parametrize(
    ("module", "command", "words", "code"),
    rows("""
numba | run scene.toml | pip install numba | 1
matplotlib | plot out.h5 | pip install matplotlib | 1
h5py | show out.h5 | h5py | 1
mpi4py | run scene.toml |  | 0
numba | show out.h5 |  | 0
matplotlib | show out.h5 |  | 0
numba | persson --hurst 0.8 --eps-f 0.01 --p-star 0.1 |  | 0
pydantic_core | info |  | 0
"""),
)
def test_a_missing_package(module, command, words, code, folder):
    from faults.seeds import seeds

    seeds("result", folder)[0].rename(folder / "out.h5")
    run = call(None, command.split(), env=without(folder, module), cwd=folder)
    assert run.returncode == int(code), run.stderr
    assert len(run.stderr.strip().splitlines()) == run.returncode
    assert words in run.stderr


NOT_LINUX = """
import builtins, io, os, random, signal, sys

import numpy

for module, names in {
    os: "sched_getaffinity posix_fallocate posix_fadvise O_TMPFILE memfd_create sysconf uname"
    " register_at_fork",
    signal: "SIGUSR1",
}.items():
    for name in names.split():
        delattr(module, name)
sys.modules.update(fcntl=None, resource=None)
original_open = io.open

def open_without_proc(path, *rest, **more):
    if str(path).startswith(("/proc", "/sys")):
        raise FileNotFoundError(path)
    return original_open(path, *rest, **more)

io.open = builtins.open = open_without_proc
from hpc_gfmd.commands.cli import main

calls = "run scene.toml,plan scene.toml,info,export contact.h5 --to csv,show contact.h5"
for line in calls.split(","):
    assert main(line.split()) == 0, line
"""


@pytest.mark.slow
def test_features_of_linux_are_not_needed(folder):
    assert "inf GiB" in printed("-c", NOT_LINUX, cwd=folder)
    assert {"contact.h5", "contact.csv"} <= {path.name for path in folder.iterdir()}
