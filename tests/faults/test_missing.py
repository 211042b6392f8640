"""Parts of the installation that are not there: not needed, or one line that says what to
install."""

import pytest
from mpi_harness import call, environment, missing

SCENE = "[surface]\nkind = 'wave'\namplitude = 0.1\nn = [8, 8]\n[load]\npressure = 0.1\n"


def without(folder, *modules):
    """An environment in which Python cannot import some modules."""
    for module in modules:
        (folder / "gone").mkdir(exist_ok=True)
        text = f"raise ModuleNotFoundError({f'No module named {module}'!r}, name={module!r})\n"
        (folder / "gone" / f"{module}.py").write_text(text)
    env = environment()
    return env | {"PYTHONPATH": f"{folder / 'gone'}:{env['PYTHONPATH']}"}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path


@pytest.mark.skipif(missing() != "", reason="needs an MPI launcher")
def test_mpirun_without_mpi4py(folder):
    run = call(2, ["run", "scene.toml"], env=without(folder, "mpi4py"), cwd=folder)
    line = run.stderr.strip()
    assert run.returncode == 1, run.stderr
    assert line.count("\n") == 0
    assert "started by an MPI launcher on 2 ranks, but mpi4py cannot be imported" in line
    assert sorted(p.name for p in folder.iterdir()) == ["gone", "scene.toml"]


@pytest.mark.parametrize(
    ("module", "args", "code", "words"),
    [
        (
            "numba",
            ["run", "scene.toml"],
            1,
            "run needs numba, which is not installed here: pip install numba",
        ),
        ("matplotlib", ["plot", "out.h5"], 1, "plot needs matplotlib"),
        ("h5py", ["show", "out.h5"], 1, "h5py"),
        ("mpi4py", ["run", "scene.toml"], 0, ""),
        ("numba", ["show", "out.h5"], 0, ""),
        ("matplotlib", ["show", "out.h5"], 0, ""),
        ("numba", ["persson", "--hurst", "0.8", "--eps-f", "0.01", "--p-star", "0.1"], 0, ""),
    ],
    ids=lambda x: " ".join(x[:2]) if isinstance(x, list) else None,
)
def test_a_missing_package(module, args, code, words, folder):
    from faults.seeds import seeds

    seeds("result", folder)[0].rename(folder / "out.h5")
    run = call(None, args, env=without(folder, module), cwd=folder)
    assert run.returncode == code, run.stderr
    assert len(run.stderr.strip().splitlines()) == (code != 0)
    assert words in run.stderr
