"""Jobs whose processes can be killed, watched and counted: nothing of them may be left, and none
may hang."""

import contextlib
import io
import os
import re
import signal
import subprocess
import sys
import time
import uuid
from pathlib import Path

import mpi_harness
import pytest
from contacts import scene_text
from result_files import assert_same_steps, names

from hpc_gfmd.commands.cli import main
from hpc_gfmd.output.folder import is_held, partial_folder
from hpc_gfmd.output.read import read_result

MARK = "HPC_GFMD_TEST_JOB"  # in the environment of all processes of a job
SABOTAGE = Path(__file__).with_name("sabotage.py")
PATIENCE = 300.0  # seconds that an undisturbed job may take here, where others compute as well
# seconds from a fault to the end of the last process; the machine of the tests may be busy
AT_ONCE = 60.0

needs_mpi = pytest.mark.skipif(bool(mpi_harness.missing()), reason="mpirun or mpi4py is missing")


class Job:
    """`mpirun -n ranks python -m hpc_gfmd` with these words (ranks None: without mpirun), started
    in the folder cwd.

    fault: words for sabotage.py, which then starts the program; wrapped: command put before it all.
    """

    def __init__(self, words, ranks=None, cwd=None, fault=None, wrapped=()):
        self.mark = uuid.uuid4().hex
        program = ["-m", "hpc_gfmd"] if fault is None else [SABOTAGE, *fault.split(), "--"]
        launcher = ["mpirun", "-n", ranks] if ranks else []
        command = [*wrapped, *launcher, sys.executable, *program, *words.split()]
        self.process = subprocess.Popen(
            [str(part) for part in command],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            text=True,
            env=mpi_harness.environment(**{MARK: self.mark}),
        )
        self.begun = self.hit = time.monotonic()

    def pids(self):
        """All processes of the job that live, that of mpirun or the program first."""
        pids = []
        for folder in Path("/proc").iterdir():
            try:
                if (
                    folder.name.isdigit()
                    and f"{MARK}={self.mark}".encode() in (folder / "environ").read_bytes()
                ):
                    pids.append(int(folder.name))
            except OSError:  # ended, or not ours
                continue
        return sorted(pids, key=lambda pid: (pid != self.process.pid, pid))

    def ranks(self):
        """The processes that compute."""
        return [
            pid
            for pid in self.pids()
            if b"hpc_gfmd" in command_of(pid) or b"sabotage" in command_of(pid)
            if b"mpirun" not in command_of(pid)
        ]

    def kill(self, sign, *pids):
        """Send a signal; the time of the fault."""
        self.hit = time.monotonic()
        for pid in pids or (self.process.pid,):
            try:
                os.kill(pid, sign)
            except ProcessLookupError:
                pass

    def wait_for(self, happened, patience=PATIENCE):
        """Until happened() is true; returns whether that was before the job ended."""
        while not happened():
            if self.process.poll() is not None:
                return False
            assert time.monotonic() - self.begun < patience, "nothing happened"
            time.sleep(0.002)
        return True

    def end(self, patience=AT_ONCE):
        """Wait for the end of all processes; sets code, out, err. Fails if that takes too
        long."""
        try:
            self.out, self.err = self.process.communicate(
                timeout=max(patience - (time.monotonic() - self.hit), 0.1)
            )
            while self.pids():
                assert time.monotonic() - self.hit < patience, (
                    f"processes are left: {[command_of(pid) for pid in self.pids()]}"
                )
                time.sleep(0.01)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"the job hangs {patience:g} s after the fault") from None
        finally:
            for pid in self.pids():
                os.kill(pid, signal.SIGKILL)
            self.process.wait()
        self.code = (
            self.process.returncode
            if self.process.returncode >= 0
            else 128 - self.process.returncode
        )
        return self

    def one_line(self):
        """What the job said on stderr: one line, once, no traceback. (mpirun may add lines of its
        own.)"""
        lines = [line for line in self.err.splitlines() if line.startswith("hpc-gfmd:")]
        assert len(lines) == 1, self.err
        assert "Traceback" not in self.err or "internal error" in lines[0], self.err
        return lines[0]

    def says(self, pattern):
        """The one line matches."""
        assert re.search(pattern, self.one_line()), self.one_line()


def command_of(pid):
    """The command line of a process, as bytes with nulls; nothing of one that is gone."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def run(words, ranks=None, cwd=None, **how):
    """A job from its start to its end."""
    return Job(words, ranks, cwd, **how).end(PATIENCE)


EIGHT = [round(0.02 * 1.2**i, 6) for i in range(8)]


def write_scene(folder=Path(), lam=32, loads=EIGHT[:5], residual=1e-8, fields=("gap",)):
    """scene.toml of a sweep, most loads of which start from the one before."""
    (folder / "scene.toml").write_text(
        scene_text(
            (2, lam, 2),
            loads,
            solver={"residual": residual, "precision": "double"},
            output={"path": "out.h5", "fields": list(fields)},
        )
    )
    return folder / "out.h5"


def nothing_wrong(path, wanted, rel=0.0):
    """What can be read is right: a file under its final name is complete, finished steps are those
    of the undisturbed run, within a relative tolerance where the run has gone on.

    Returns how many steps there are."""
    if path.exists():
        result = read_result(path)
        assert result.indices == wanted.indices
        assert_same_steps(result, wanted, rel)
        return len(wanted.steps)
    if (partial_folder(path) / "head.h5").exists():
        begun = time.monotonic()
        while is_held(partial_folder(path)) and time.monotonic() - begun < 5:
            time.sleep(0.01)  # a process that was killed gives back its files last
        result = read_result(path)
        assert result.status == "interrupted", result.status
        assert_same_steps(result, wanted, rel)
        return len(result.steps)
    return 0


def goes_on(path, wanted, ranks, kept=0):
    """What is there is right, so many loads at least, and so is what comes of them in the end: by
    the same command, which removes no finished load; no temporary files are left then."""
    assert nothing_wrong(path, wanted) >= kept
    begun = (partial_folder(path) / "head.h5").exists()
    loads = [*partial_folder(path).glob("step-[0-9]*.h5")] if begun else []
    job = call("run scene.toml", ranks, path.parent)
    assert job.code == 0, job.err
    assert not loads or re.search(
        rf"resuming .*: {len(loads)} loads? (is|are) finished", job.out
    ), job.out
    assert names(path.parent) == ["out.h5", "scene.toml"]
    nothing_wrong(path, wanted, rel=1e-6)


def call(words, ranks=None, cwd="."):
    """As `run`, in this process where one is enough (ranks None): much faster."""
    if ranks:
        return run(words, ranks, cwd)
    job = Job.__new__(Job)
    out = io.StringIO()
    err = io.StringIO()
    with contextlib.chdir(cwd), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        job.code = main(words.split())
    job.out = out.getvalue()
    job.err = err.getvalue()
    return job
