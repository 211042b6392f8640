"""mpirun on a terminal: rank 0 draws a progress bar although its standard error is a pipe, and
Ctrl-C prints how to resume."""

import os
import select
import shutil
import sys
import time
from pathlib import Path

import mpi_harness
import pytest
from faults.jobs import PATIENCE, needs_mpi, write_scene

pty = pytest.importorskip("pty")
termios = pytest.importorskip("termios")


def on_terminal(command, shown, env):
    """Run a command on a new terminal and press Ctrl-C once it has shown some text.

    Returns its output and exit code.
    """
    pid, terminal = pty.fork()
    if pid == 0:
        os.execvpe(command[0], command, env)
    termios.tcsetwinsize(terminal, (40, 120))
    text = ""
    pressed = False
    begun = time.monotonic()
    try:
        while time.monotonic() - begun < PATIENCE:
            if select.select([terminal], [], [], 0.1)[0]:
                try:
                    data = os.read(terminal, 2**16)
                except OSError:  # closed
                    break
                text += data.decode(errors="replace")
            if shown in text and not pressed:
                os.write(terminal, b"\x03")
                pressed = True
        else:
            os.kill(pid, 9)
    finally:
        os.close(terminal)
    _, status = os.waitpid(pid, 0)
    assert pressed, text
    return text, os.waitstatus_to_exitcode(status)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [None, pytest.param(2, marks=needs_mpi)])
def test_ctrl_c(ranks):
    write_scene(lam=256, loads=[0.02, 0.1, 0.2])
    launcher = ["mpirun", "-n", str(ranks)] if ranks else []
    python = shutil.which(sys.executable) or sys.executable
    command = [*launcher, python, "-m", "hpc_gfmd", "run", "scene.toml"]
    env = mpi_harness.environment()
    env.pop("HPC_GFMD_PROGRESS", None)
    text, code = on_terminal(command, "load 1/3", env)
    assert "|" in text[text.index("load 1/3") :]
    assert "hpc-gfmd restart out.h5" in text
    assert code == (1 if ranks and "Open MPI" in mpi_version() else 130), text
    assert sorted(path.name for path in Path().iterdir()) == ["out.h5.partial", "scene.toml"]


def mpi_version():
    """Return the output of mpirun --version."""
    return os.popen("mpirun --version").read()
