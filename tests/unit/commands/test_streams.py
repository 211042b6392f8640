"""Broken output streams stop no solve, and exit code 0 means that the result is complete."""

import os
import shlex
import subprocess
import sys

import numpy as np
import pytest
import tomli_w
from contacts import WAVE_SCENE, scene_text
from mpi_harness import environment, python
from result_files import complete

from hpc_gfmd.output.read import read_result

SCENE = scene_text(title="Fl\u00e4che \u0394")
ASCII = {"PYTHONIOENCODING": "ascii", "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
ASCII_TERMINAL = "an ASCII terminal"
REDIRECTIONS = {
    "a closed pipe": "2>/dev/full | true",
    "all closed": "<&- >&- 2>&-",
    "full disk": ">/dev/full 2>&-",
    ASCII_TERMINAL: "",
}


def shell(folder, before, args, after, env=None):
    """(exit code, stdout, stderr) of `before hpc-gfmd args after`, as a line of bash."""
    command = shlex.join([*before, sys.executable, "-m", "hpc_gfmd", *args])
    completed = subprocess.run(
        ["bash", "-c", f"{command} {after}; exit ${{PIPESTATUS[0]}}"],
        cwd=folder,
        env=environment(**(env or {})),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    return completed.returncode, completed.stdout, completed.stderr


@pytest.mark.parametrize(
    "stream",
    [
        pytest.param(
            name, marks=pytest.mark.quick if name in ("a closed pipe", ASCII_TERMINAL) else ()
        )
        for name in REDIRECTIONS
    ],
)
def test_run_with_broken_streams(folder, stream):
    code, out, err = shell(
        folder, [], ["run", "scene.toml"], REDIRECTIONS[stream], ASCII if "ASCII" in stream else {}
    )
    assert code == 0, err
    assert err == ""
    assert [step["status"] for step in read_result(folder / "contact.h5").steps] == [
        "converged"
    ] * 2
    assert not (folder / "contact.h5.partial").exists()
    if "ASCII" in stream:
        assert out.startswith("Fl\\xe4che \\u0394: 32 x 32 points")
        assert "converged" in out


@pytest.mark.parametrize(
    ("args", "after", "word"),
    [
        ("show out.h5", ">/dev/full", "space"),
        ("plan scene.toml", ">&-", "standard output"),
        ("show --json out.h5", "| exec 0<&-", ""),
    ],
)
def test_commands_that_print_results_fail_without_output(folder, args, after, word):
    """Exit code 1 where the printed result is lost, without a message where a pipe was closed."""
    complete(folder / "out.h5")
    code, _, err = shell(folder, [], args.split(), after)
    assert code == 1
    assert word in err
    assert err.count("\n") == bool(word)


def test_exit_code_of_an_error_without_stderr(folder):
    assert shell(folder, [], ["show", "gone.h5"], "2>&-")[0] == 2


EACH = """
import sys
from hpc_gfmd.commands.cli import main
for words in sys.argv[1:]:
    print(main(words.split()), flush=True)
"""
ARGUMENTS = {  # of a command: the key that its message names
    "run surface.toml": "surface.path",
    "plan surface.toml": "surface.path",
    "run output.toml": "output.path",
    "run output.toml -o größe.h5": "arguments",
    "show größe.h5": "arguments",
    "init höhe.npy": "arguments",
}


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are bytes")
def test_file_names_outside_the_locale_are_refused(tmp_path):
    """The message names the locale's encoding instead of reporting a missing file."""
    np.save(tmp_path / "höhe.npy", np.eye(8))
    surface = {"kind": "file", "path": "höhe.npy", "physical_sizes": [1, 1]}
    of_a_map = tomli_w.dumps({"surface": surface, "load": {"pressure": 0.1}})
    (tmp_path / "surface.toml").write_text(of_a_map, "utf-8")
    (tmp_path / "output.toml").write_text(WAVE_SCENE + "[output]\npath = 'größe.h5'\n", "utf-8")
    before = sorted(os.listdir(tmp_path))
    completed = python(None, ["-c", EACH, *ARGUMENTS], environment(**ASCII), tmp_path)
    assert completed.stdout.split() == ["2"] * len(ARGUMENTS), completed.stderr
    for line, key in zip(completed.stderr.splitlines(), ARGUMENTS.values(), strict=True):
        assert all(word in line for word in (key, "ascii", "PYTHONUTF8=1"))
    assert sorted(os.listdir(tmp_path)) == before
