"""The script of `--print-completion` completes commands, options and files."""

import shutil
import subprocess

import pytest
from mpi_harness import printed


def completed(script, words):
    """What bash offers as completions of the last word."""
    line = " ".join(words)
    program = f"""
        source {script}
        COMP_WORDS=({line}{' ""' if words[-1] == "" else ""})
        COMP_CWORD={len(words) - 1}
        COMP_LINE="{line}"
        _shtab_hpc_gfmd
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    process = subprocess.run(
        ["bash", "-c", program], capture_output=True, text=True, check=True, timeout=30
    )
    return process.stdout.split()


@pytest.mark.skipif(not shutil.which("bash"), reason="no bash")
def test_bash(tmp_path):
    script = tmp_path / "completion.bash"
    script.write_text(printed("-m", "hpc_gfmd", "--print-completion", "bash"))
    (tmp_path / "scene.toml").touch()
    assert {"plan", "plot"} <= set(completed(script, ["hpc-gfmd", "pl"]))
    assert "--force" in completed(script, ["hpc-gfmd", "run", "--fo"])
    assert "gwy" in completed(script, ["hpc-gfmd", "export", "--to", "g"])
    assert "scene.toml" in completed(script, ["hpc-gfmd", "run", "sce"])
