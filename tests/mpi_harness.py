"""Programs that tests start, and tests that run on several ranks.

`mpirun -n 2 python -m pytest -m mpi` runs the tests marked `mpi` on every rank at once. A test
passes if it passes on all ranks; rank 0 reports. A rank that hangs, or waits for a failed one, ends
all of them.
"""

import faulthandler
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import pytest

import hpc_gfmd
from hpc_gfmd.parallel.world import world

TIMEOUT = float(os.environ.get("HPC_GFMD_TEST_TIMEOUT", "300"))  # seconds for one test
GRACE = 15  # seconds that a failed rank waits for the others before it aborts them
EVENTS = "[warn] Epoll "  # warnings that mpirun's event library may print when ranks end


def missing():
    """Names of missing programs and libraries for tests on several ranks, or ""."""
    lacking = [] if shutil.which("mpirun") else ["mpirun"]
    return " and ".join(lacking + ([] if find_spec("mpi4py") else ["mpi4py"]))


def environment(**extra):
    """The environment for processes started by tests.

    This package and the test helpers can be imported; MPI accepts root and more ranks than cores.
    """
    launcher = ("OMPI_COMM", "PMIX_", "PMI_", "PRTE_", "ORTE_")  # of a launcher around the parent
    env = {k: v for k, v in os.environ.items() if not k.startswith(launcher)}
    helpers = Path(__file__).parent
    paths = [str(Path(hpc_gfmd.__file__).parents[1]), str(helpers), env.get("PYTHONPATH", "")]
    env |= {
        "PYTHONPATH": os.pathsep.join(filter(None, paths)),
        "OMP_NUM_THREADS": "1",
        "OMPI_MCA_orte_execute_quiet": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
        "OMPI_MCA_mpi_yield_when_idle": "1",  # more ranks than cores: do not spin
    }
    if os.getuid() == 0:
        env |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return env | extra


def end(process):
    """Terminate a process and its children."""
    # on SIGTERM mpirun kills its ranks, which have groups of their own
    for sign in (signal.SIGTERM, signal.SIGKILL):
        if process.poll() is None:
            os.killpg(process.pid, sign)
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                continue


def call(ranks, args, **options):
    """Run `python -m hpc_gfmd args`; options as of `python`."""
    return python(ranks, ["-m", "hpc_gfmd", *args], **options)


def json_of(ranks, args, **options):
    """The JSON that a script prints as its last line."""
    completed = python(ranks, args, **options)
    assert completed.returncode == 0, completed.stderr
    return json.loads(completed.stdout.splitlines()[-1])


def printed(*args, cwd=None, **variables):
    """The output of `python args`, which has to succeed; variables: added to its environment."""
    completed = python(None, args, environment(**variables), cwd)
    assert completed.returncode == 0, completed.stderr
    return completed.stdout


def python(ranks, args, env=None, cwd=None, timeout=None):
    """Run `python args` on a number of ranks (None: without mpirun); returns a CompletedProcess.

    A run of more than `timeout` seconds is terminated and fails the test.
    """
    if ranks is None:
        return subprocess.run(
            [sys.executable, *map(str, args)],
            capture_output=True,
            text=True,
            env=env or environment(),
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            timeout=timeout or TIMEOUT,
            check=False,
        )
    process = subprocess.Popen(
        ["mpirun", "-n", str(ranks), sys.executable, *map(str, args)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL,
        env=env or environment(),
        cwd=cwd,
        start_new_session=True,
    )
    try:
        out, err = process.communicate(timeout=timeout or TIMEOUT)
    except subprocess.TimeoutExpired:
        raise AssertionError(
            f"{ranks} ranks did not end within {timeout or TIMEOUT:g} s: {args}"
        ) from None
    finally:
        end(process)
    lines = err.decode().splitlines(keepends=True)
    errors = "".join(line for line in lines if not line.startswith(EVENTS))
    return subprocess.CompletedProcess(args, process.returncode, out.decode(), errors)


class OnRanks:
    """Plugin of the pytest on each rank: at the end of each test the ranks agree on its outcome."""

    def __init__(self):
        self.mpi = world().mpi.Dup()  # the world communicator may be in use when a rank fails
        self.failure = ""

    def pytest_runtest_logstart(self):
        self.failure = ""
        faulthandler.dump_traceback_later(TIMEOUT, exit=True, file=sys.__stderr__)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, call):
        report = yield
        if report.failed:
            self.failure += report.longreprtext
        if call.when == "teardown":
            faulthandler.cancel_dump_traceback_later()
            self._agree(report)
        return report

    def _agree(self, report):
        """Let the test fail here if it has failed on another rank."""
        arrived = self.mpi.Ibarrier()
        since = time.monotonic()
        while not arrived.Test():
            time.sleep(0.001)
            if self.failure and time.monotonic() - since > GRACE:
                print(
                    f"rank {self.mpi.rank} alone:\n{self.failure}", file=sys.__stderr__, flush=True
                )
                self.mpi.Abort(1)
        failures = self.mpi.allgather(self.failure)
        if any(failures) and not self.failure:
            report.outcome = "failed"
            texts = [f"rank {rank}: {text}" for rank, text in enumerate(failures) if text]
            report.longrepr = "\n".join(texts)
