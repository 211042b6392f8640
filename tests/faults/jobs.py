"""Jobs whose processes can be killed and counted: none may be left over, and none may hang."""

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
from hpc_gfmd.output.folder import has_begun, is_held, partial_folder
from hpc_gfmd.output.read import read_partial, read_result

MARK = "HPC_GFMD_TEST_JOB"  # variable in the environment of all processes of a job
SABOTAGE = Path(__file__).with_name("sabotage.py")
PATIENCE = 300.0  # seconds that an undisturbed job may take on a busy machine
AT_ONCE = 60.0  # seconds from a fault to the end of the last process on a busy machine

needs_mpi = pytest.mark.skipif(bool(mpi_harness.missing()), reason="mpirun or mpi4py is missing")


class Job:
    """A running `hpc-gfmd`, perhaps under mpirun.

    Parameters
    ----------
    words : str
        Its arguments.
    ranks : int, optional
        Number of ranks; without mpirun by default.
    cwd : Path, optional
        Folder in which it runs.
    fault : str, optional
        Arguments of sabotage.py, which then starts the program.
    wrapped : sequence of str
        Command that starts it all.

    Attributes
    ----------
    hit : float
        Time of the fault.
    code, out, err
        Exit code and output, after `end`.
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
        self.begun = time.monotonic()
        self.hit = self.begun

    def pids(self):
        """Return the living processes of the job, that of mpirun or the program first."""
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
        """Return the processes that compute."""
        return [
            pid
            for pid in self.pids()
            if b"hpc_gfmd" in command_of(pid) or b"sabotage" in command_of(pid)
            if b"mpirun" not in command_of(pid)
        ]

    def kill(self, sign, *pids):
        """Send a signal to some processes, or to the first one, and note the time of the fault."""
        self.hit = time.monotonic()
        for pid in pids or (self.process.pid,):
            try:
                os.kill(pid, sign)
            except ProcessLookupError:
                pass

    def wait_for(self, happened, patience=PATIENCE):
        """Wait until happened() is true; return whether that was before the end of the job."""
        while not happened():
            if self.process.poll() is not None:
                return False
            assert time.monotonic() - self.begun < patience, "it did not happen in time"
            time.sleep(0.002)
        return True

    def end(self, patience=AT_ONCE):
        """Wait for the end of all processes and set code, out, err; fail if it takes too long."""
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
        """Return the only line of hpc-gfmd on stderr, which has no traceback.

        mpirun may add lines.
        """
        lines = [line for line in self.err.splitlines() if line.startswith("hpc-gfmd:")]
        assert len(lines) == 1, self.err
        assert "Traceback" not in self.err or "internal error" in lines[0], self.err
        return lines[0]

    def says(self, pattern):
        """Assert that the line on stderr matches."""
        assert re.search(pattern, self.one_line()), self.one_line()


def command_of(pid):
    """Return the command line of a process, with nulls between words; empty if it has ended."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def run(words, ranks=None, cwd=None, **settings):
    """Run a job to its end and return it."""
    return Job(words, ranks, cwd, **settings).end(PATIENCE)


LOADS = [round(0.02 * 1.2**i, 6) for i in range(5)]


def write_scene(folder=Path(), lam=32, loads=LOADS, residual=1e-8, hardness=None):
    """Write scene.toml of a sweep, with a hardness of a history, and return the path of its
    result."""
    dents = {"material": {"hardness": hardness}} if hardness else {}
    (folder / "scene.toml").write_text(
        scene_text(
            (2, lam, 2),
            load={"p_star": list(loads), "history": hardness is not None},
            solver={"residual": residual, "precision": "double"},
            output={"path": "out.h5", "fields": ["gap", "dent"] if hardness else ["gap"]},
            **dents,
        )
    )
    return folder / "out.h5"


def assert_sound(path, expected, rel=0.0):
    """Assert that what can be read is right and return the number of finished steps.

    A file under its final name is complete. Finished steps are those of the undisturbed run, within
    a relative tolerance after a restart.
    """
    if path.exists():
        result = read_result(path)
        assert result.indices == expected.indices
        assert_same_steps(result, expected, rel)
        return len(expected.steps)
    if has_begun(partial_folder(path)):
        begun = time.monotonic()
        while is_held(partial_folder(path)) and time.monotonic() - begun < 5:
            time.sleep(0.01)  # a killed process releases its files last
        result = read_result(path)
        assert result.status == "interrupted", result.status
        assert_same_steps(result, expected, rel)
        return len(result.steps)
    return 0


def loads_in(path):
    """Return the number of finished loads of an unfinished run."""
    return len(read_partial(path).steps) if has_begun(partial_folder(path)) else 0


def assert_resumes(path, expected, ranks, kept=0):
    """Assert that the same command resumes a run, with the right result.

    At least `kept` loads are finished before; none of the finished ones is solved again, and no
    temporary files are left in the end.
    """
    assert assert_sound(path, expected) >= kept
    loads = loads_in(path)
    job = call("run scene.toml", ranks, path.parent)
    assert job.code == 0, job.err
    assert not loads or re.search(rf"resuming .*: {loads} loads? (is|are) finished", job.out), (
        job.out
    )
    assert names(path.parent) == ["out.h5", "scene.toml"]
    assert_sound(path, expected, rel=1e-6)


def call(words, ranks=None, cwd="."):
    """Do the same as `run`, but within this process if ranks is None, which is much faster."""
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
