"""What tests of faults share: `record`, which keeps what happened for the table in docs/faults."""

import json
import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest
from faults.jobs import call, write_scene

from hpc_gfmd.output.read import read_result

RECORDS = "docs/faults/faults.jsonl"  # one JSON object a line; report.py makes the table of it
FORMAT = ("fault", "how", "code", "message", "seconds", "lost", "command")


@pytest.fixture
def record(request):
    """record(fault, how, code, message, seconds, lost="nothing"): what a fault did, kept when pytest has --record-faults.

    fault: its name, one line of the table; how: it was provoked; code: the exit code, or a text; message: the line on stderr;
    seconds: from the fault to the end of the last process. The command that repeats it is that of the test. A later record of the
    same fault by the same test replaces the earlier one.
    """
    def keep(fault, how, code, message, seconds, lost="nothing"):
        slow = "-m slow " if request.node.get_closest_marker("slow") else ""
        command = f"pytest {slow}'{request.node.nodeid}'"
        line = dict(zip(FORMAT, (fault, how, code, _short(message, request), round(float(seconds), 1), lost, command)))
        if request.config.getoption("--record-faults"):
            _keep(request.config.rootpath / RECORDS, line)

    return keep


def _short(message, request):
    """On one line, the folder of the test as "."."""
    return " ".join(str(message).split()).replace(str(request.node.funcargs.get("tmp_path", "\n")), ".")


def _keep(path: Path, line):
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [json.loads(text) for text in path.read_text().splitlines()] if path.exists() else []
    lines = [old for old in lines if (old["fault"], old["command"]) != (line["fault"], line["command"])] + [line]
    lines.sort(key=lambda one: (one["command"], one["fault"]))
    path.write_text("".join(json.dumps(one) + "\n" for one in lines))


@pytest.fixture
def stopwatch():
    """stopwatch(): seconds since the test began, or since it was called before."""
    last = [time.monotonic()]

    def seconds():
        last.append(time.monotonic())
        return last[-1] - last[-2]

    return seconds


@pytest.fixture(scope="session")
def small_disk():
    """A function that mounts a tmpfs of some bytes on a folder; skips where that is not allowed."""
    mounted = []

    def mount(folder, size):
        if os.getuid() != 0 or not shutil.which("mount"):
            pytest.skip("only root can mount a small disk")
        command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.skip(f"mounting is not allowed: {done.stderr.strip()}")
        mounted.append(folder)
        return folder

    yield mount
    for folder in mounted:
        subprocess.run(["umount", "-l", folder], check=False)


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory):
    """undisturbed(ranks, **how): the result of the run to which nothing happens; how: as for jobs.write_scene."""
    made = {}

    def result(ranks, **how):
        key = (ranks, str(how))
        if key not in made:
            path = write_scene(tmp_path_factory.mktemp("undisturbed"), **how)
            job = call(["run", "scene.toml", "-q"], ranks, path.parent)
            assert job.code == 0, job.err
            made[key] = read_result(path)
        return made[key]

    return result
