"""Runs tests on several ranks from a plain pytest: one mpirun per number of ranks for all tests.

The pytest that a person starts (the parent) never initialises MPI. It gives a test marked `mpi` one
item per number of ranks. The first item of a number starts `mpirun -n k pytest` (the children) with
all items of this number; each rank appends outcomes to a file of JSON lines, from which the parent
reports the items one by one. A test that hangs or crashes fails alone: the rest is started again.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

import hpc_gfmd

REPORT = "HPC_GFMD_TEST_REPORT"  # set for children: the folder of the reports
RANKS = "HPC_GFMD_TEST_RANKS"
TIMEOUT = float(os.environ.get("HPC_GFMD_TEST_TIMEOUT", "300"))  # seconds for one test
GRACE = 15  # seconds that a failed rank waits for the others before it aborts them
EVENTS = "[warn] Epoll "  # warnings that mpirun's event library may print when ranks end


def is_child():
    """Whether mpirun started this pytest."""
    return REPORT in os.environ


def rank_counts():
    """Numbers of ranks to test."""
    return [int(os.environ[RANKS])] if os.environ.get(RANKS) else [1, 2, 3, 4]


def missing():
    """Names of missing programs and libraries for tests on several ranks, or ""."""
    lacking = [] if shutil.which("mpirun") else ["mpirun"]
    return " and ".join(lacking + ([] if find_spec("mpi4py") else ["mpi4py"]))


def must_run():
    """Whether missing MPI is an error: in continuous integration, or if HPC_GFMD_TEST_RANKS is
    set."""
    return bool(os.environ.get(RANKS)) or os.environ.get("CI", "").lower() in ("1", "true", "yes")


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


def start(ranks, args, stream, env=None, cwd=None):
    """Start `mpirun -n ranks python args...` in a new process group.

    stream: open file, or subprocess.PIPE, that receives the output.
    """
    command = ["mpirun", "-n", str(ranks), sys.executable, *map(str, args)]
    return subprocess.Popen(
        command,
        stdout=stream,
        stderr=subprocess.STDOUT if stream is not subprocess.PIPE else subprocess.PIPE,
        stdin=subprocess.DEVNULL,
        env=env or environment(),
        cwd=cwd,
        start_new_session=True,
    )


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
    process = start(ranks, args, subprocess.PIPE, env, cwd)
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


# ---- the parent


def run(root, ranks, names):
    """Run tests (node ids without numbers of ranks) under mpirun; {name: (outcome, text)}."""
    results = {}
    missing_names = list(names)
    while missing_names:
        reported = _launch(root, ranks, missing_names)
        results |= reported
        missing_names = [name for name in missing_names if name not in reported]
    return results


def _launch(root, ranks, names):
    """Results of one mpirun, which has at least the outcome of one test."""
    with tempfile.TemporaryDirectory(prefix="hpc-gfmd-test-") as folder:
        folder = Path(folder)
        words = (
            f"-m mpi4py -m pytest -q --tb=short -p no:cacheprovider --basetemp={folder}/unused"
            f" -o faulthandler_timeout={TIMEOUT * 0.8:g}"
        )
        args = [*words.split(), *names]
        with open(folder / "output", "w+b") as output:
            process = start(ranks, args, output, environment(**{REPORT: str(folder)}), cwd=root)
            try:
                why = _wait(process, folder, ranks)
            finally:
                end(process)
            output.seek(0)
            text = output.read().decode(errors="replace")
        return _merge(folder, ranks, names, why, text)


def _wait(process, folder, ranks):
    """Wait for the end, at most TIMEOUT seconds without any report; returns what went wrong."""
    size = -1
    since = time.monotonic()
    while process.poll() is None:
        time.sleep(0.05)
        reported_bytes = sum(p.stat().st_size for p in folder.glob("report.*"))
        if reported_bytes != size:
            size = reported_bytes
            since = time.monotonic()
        elif time.monotonic() - since > TIMEOUT:
            end(process)
            return f"nothing happened for {TIMEOUT:g} s on {ranks} ranks"
    return f"mpirun ended with exit code {process.returncode}"


def _merge(folder, ranks, names, why, output):
    """Combine the reports of all ranks to {name: (outcome, text)}; `why` explains missing ones."""
    reports = [_read(folder / f"report.{rank}") for rank in range(ranks)]
    results = {}
    for name in names:
        reports_of_ranks = [report.get(name) for report in reports]
        outcomes = [f["outcome"] for f in reports_of_ranks if f]
        text = "\n".join(
            f"---- rank {rank} of {ranks}\n{f['text']}"
            for rank, f in enumerate(reports_of_ranks)
            if f and f["text"]
        )
        if "failed" in outcomes:
            results[name] = "failed", text
        elif "started" in outcomes:
            results[name] = "failed", f"{why}\n{text}\n{output[-6000:]}"
        elif len(outcomes) == ranks:
            results[name] = ("skipped" if "skipped" in outcomes else "passed"), text
    if not results:  # no test has begun, and a second mpirun would not begin one either
        results = dict.fromkeys(names, ("failed", f"{why}\n{output[-6000:]}"))
    return results


def _read(path):
    """The last entry of every test."""
    lines = path.read_text().splitlines() if path.exists() else []
    entries = {}
    for line in lines:
        try:
            entry = json.loads(line)
        except ValueError:  # cut off by the end of the process
            continue
        entries[entry["test"]] = entry
    return entries


# ---- the children


class Child:
    """Plugin of the pytest on each rank: writes reports, and synchronises ranks between tests."""

    def __init__(self):
        from mpi4py import MPI

        self.mpi = MPI.COMM_WORLD
        # the world communicator may be in use when a rank fails
        self.agreement = self.mpi.Dup()
        self.file = open(  # noqa: SIM115
            Path(os.environ[REPORT]) / f"report.{self.mpi.rank}", "a", encoding="utf-8"
        )
        self.outcome = "passed"
        self.text = ""

    def _write(self, test, outcome, text=""):
        self.file.write(json.dumps({"test": test, "outcome": outcome, "text": text}) + "\n")
        self.file.flush()

    def pytest_runtest_logstart(self, nodeid, location):
        self.outcome = "passed"
        self.text = ""
        self._write(nodeid, "started")

    def pytest_runtest_logreport(self, report):
        if report.outcome == "failed":
            sections = "".join(f"\n{title}\n{text}" for title, text in report.sections)
            self.outcome = "failed"
            self.text = self.text + report.longreprtext + sections
            self._write(report.nodeid, "failed", self.text)
        elif report.outcome == "skipped" and self.outcome == "passed":
            self.outcome = "skipped"
            self.text = str(
                report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
            )

    def pytest_runtest_logfinish(self, nodeid, location):
        arrived = self.agreement.Ibarrier()
        since = time.monotonic()
        while not arrived.Test():
            time.sleep(0.001)
            if self.outcome == "failed" and time.monotonic() - since > GRACE:
                self.mpi.Abort(1)
        if self.outcome != "failed":
            self._write(nodeid, self.outcome, self.text)
