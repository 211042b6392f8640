"""Detection of the launcher, automatic threads, notes on cores, and messages without MPI."""

import os
import sys
from pathlib import Path
from unittest import mock

import pytest
from contacts import WAVE_SCENE
from mpi_harness import environment, python
from refusal import refused

from hpc_gfmd.parallel import launcher, thread_count, world
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.launcher import launched, launcher_rank
from hpc_gfmd.parallel.world import load_mpi
from hpc_gfmd.util.errors import GfmdError

VARIABLES = (
    *launcher.LAUNCHER_SIZE,
    *launcher.LAUNCHER_RANK,
    launcher.LOCAL_SIZE,
    launcher.LAUNCHER,
    "SLURM_PROCID",
    "SLURM_STEP_NUM_TASKS",
    "SLURM_NTASKS",
)


@pytest.fixture
def alone(monkeypatch):
    """No launcher's variable is set, and `world.world()` has not been called."""
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(world, "_world", None)


def test_launcher_and_its_override(alone, monkeypatch):
    assert launched() == (False, None)
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "4")
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "2")
    assert (launched(), launcher_rank()) == ((True, 4), 2)
    monkeypatch.setenv("HPC_GFMD_LAUNCHER", "none")
    assert (launched(), launcher_rank()) == ((False, None), 0)
    monkeypatch.delenv("OMPI_COMM_WORLD_SIZE")
    monkeypatch.delenv("OMPI_COMM_WORLD_RANK")
    monkeypatch.setenv("HPC_GFMD_LAUNCHER", "mpi")
    assert launched() == (True, None)
    monkeypatch.setenv("HPC_GFMD_LAUNCHER", "slurm")
    with refused(r'HPC_GFMD_LAUNCHER: found "slurm", allowed: "mpi", "none"'):
        world.world()


class Library:
    """mpi4py.MPI with a communicator of some ranks."""

    def __init__(self, size):
        self.COMM_WORLD = self
        self.Get_size = lambda: size
        self.Get_rank = lambda: 0
        self.allgather = self.gather = None
        self.get_vendor = lambda: ("Another MPI", ())


@pytest.mark.parametrize(
    ("variables", "ranks", "expected"),
    [
        ({"MPI_LOCALNRANKS": "1"}, 2, 2),  # one rank on each of two machines
        ({"MPI_LOCALNRANKS": "1"}, 1, 1),
        ({"PMI_SIZE": "2", "MPI_LOCALNRANKS": "1"}, 1, "sees one"),
    ],
)
def test_the_library_tells_how_many_ranks_there_are(variables, ranks, expected, alone, monkeypatch):
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    monkeypatch.setattr(world, "enclosing_mpi_program", lambda: None)
    monkeypatch.setattr(world, "load_mpi", lambda: Library(ranks))
    if isinstance(expected, int):
        assert world.world().size == expected
    else:
        with pytest.raises(GfmdError, match=expected):
            world.world()


def test_a_batch_job_of_several_tasks_without_a_launcher_is_noted(alone, monkeypatch):
    monkeypatch.setenv("SLURM_NTASKS", "4")
    note = thread_count.oversubscription(SerialComm(), 1)
    assert "4 tasks" in note
    assert "srun or mpirun" in note
    monkeypatch.setenv("SLURM_STEP_NUM_TASKS", "1")  # srun -n 1
    assert thread_count.oversubscription(SerialComm(), 1) == ""


def test_automatic_threads(monkeypatch):
    """Slurm's cores per task; without Slurm all cores for large grids and one for small ones."""
    monkeypatch.delenv("SLURM_CPUS_PER_TASK", raising=False)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: range(12))
    few = thread_count.THREADED_POINTS - 1
    many = thread_count.THREADED_POINTS
    for slurm, points, threads in (("", many, 12), ("", few, 1), ("3", few, 3), ("4096", many, 12)):
        monkeypatch.setenv("SLURM_CPUS_PER_TASK", slurm)
        assert thread_count.threads_of(SerialComm(), "auto", points) == threads
    assert thread_count.auto_threads(many, 2, 12) == 1


def processes(folder, *ancestors):
    """Make a folder like /proc.

    ancestors: (name, loaded libraries) of processes, each the parent of the one before.
    """
    for k, (name, libraries) in enumerate(ancestors):
        place = folder / str(100 + k)
        place.mkdir()
        (place / "stat").write_text(f"{100 + k} ({name}) S {101 + k} 1 1")
        (place / "maps").write_text(f"7f00-7f01 r-xp 0 00:00 1 /usr/lib/{libraries}\n")
        (place / "cmdline").write_bytes(b"python\0optimise.py\0")


@pytest.mark.parametrize(
    ("chain", "program"),
    [
        ([("bash", "libc.so.6"), ("a (b) c", "libmpich.so.12")], "python optimise.py"),
        ([("bash", "libc.so.6"), ("hydra_pmi_proxy", "libc.so.6")], None),
        ([("mpirun", "libc.so.6"), ("python", "libmpi.so.40")], None),
    ],
)
def test_enclosing_mpi_program(chain, program, tmp_path, monkeypatch):
    processes(tmp_path, *chain)
    monkeypatch.setattr(os, "getppid", lambda: 100)
    assert launcher.enclosing_mpi_program(tmp_path) == program


@pytest.mark.parametrize(
    ("package", "words"),
    [
        (None, ["hpc-gfmd[mpi]"]),
        (
            "raise RuntimeError('cannot load MPI library\\nlibmpi.so.12: no such file')",
            ["cannot load MPI library", "--no-binary=mpi4py"],
        ),
        ("raise ImportError('libmpi.so.40: cannot open')", ["libmpi.so.40", "--no-binary=mpi4py"]),
    ],
)
@mock.patch.dict(sys.modules)  # what is imported here is forgotten
def test_message_without_mpi(package, words, tmp_path, monkeypatch):
    """A missing mpi4py and one that does not find its library give different messages."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "mpi4py"]:
        del sys.modules[name]
    if package is None:
        sys.modules["mpi4py"] = None
    else:
        (tmp_path / "mpi4py").mkdir()
        Path("mpi4py/__init__.py").write_text("__version__ = '4'\n")
        Path("mpi4py/MPI.py").write_text(package)
        monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(GfmdError) as caught:
        load_mpi()
    assert all(word in str(caught.value) for word in words)
    assert str(caught.value).isprintable()


INSIDE = """
import os, subprocess, sys, time
from mpi4py import MPI

words = [sys.executable, "-m", "hpc_gfmd", "run", "scene.toml"]
for setting in (None, "none")[: 2 - MPI.COMM_WORLD.rank]:
    env = os.environ | ({"HPC_GFMD_LAUNCHER": setting} if setting else {})
    completed = subprocess.run(words, capture_output=True, text=True, env=env)
    print("##", completed.returncode, completed.stderr.strip(), flush=True)
meeting = MPI.COMM_WORLD.Ibarrier()
while not meeting.Test():
    time.sleep(0.01)
"""
SCENE = WAVE_SCENE


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="needs /proc")
def test_a_run_inside_another_mpi_program(folder):
    """The refusal is one line with the way out; MPI itself would print a page and abort."""
    pytest.importorskip("mpi4py")
    Path("inside.py").write_text(INSIDE)
    completed = python(2, ["inside.py"], environment(), folder)
    lines = sorted(line.strip() for line in completed.stdout.splitlines())
    alone, silent, refusal = lines
    assert (alone, silent) == ("## 0", "## 1"), completed.stdout + completed.stderr
    assert refusal.startswith("## 1 hpc-gfmd:")  # of rank 0
    assert "inside.py" in refusal
    assert "HPC_GFMD_LAUNCHER=none" in refusal
    assert (folder / "contact.h5").exists()
