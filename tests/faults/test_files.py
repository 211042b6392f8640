"""Bad files of every kind: a single line, exit code 2, no files written, no code executed."""

import pytest
import tomli_w
from contacts import rough
from faults.bad_files import HEIGHT_MAPS, RESULTS, cut


@pytest.fixture
def refused(tmp_path, cli):
    """refused(*args, code=2) runs a command and returns its line on stderr; it writes no files."""

    def run(*args, code=2):
        before = sorted(tmp_path.rglob("*"))
        line = cli.refused(*args, code=code)
        assert len(line) < 1000
        assert sorted(tmp_path.rglob("*")) == before
        return line

    return run


@pytest.mark.parametrize("fault", HEIGHT_MAPS)
def test_height_map(fault, tmp_path, refused):
    extension, make, words = HEIGHT_MAPS[fault]
    path = tmp_path / f"z{extension}"
    make(path)
    scene = {
        "surface": {"kind": "file", "physical_sizes": [1, 1], "path": path.name},
        "load": {"pressure": 0.1},
    }
    (tmp_path / "scene.toml").write_text(tomli_w.dumps(scene | {"solver": {"max_iterations": 1}}))
    line = refused("run", "scene.toml")
    assert words in line
    assert path.name in line or "GiB" in line
    assert not (tmp_path / "trapped").exists()


@pytest.mark.parametrize("fault", RESULTS)
def test_result_file(fault, tmp_path, refused):
    make, words = RESULTS[fault]
    path = tmp_path / "out.h5"
    make(path)
    assert words in refused("show", "out.h5")
    for command in (["plot", "out.h5"], ["restart", "out.h5"], ["export", "out.h5", "--to", "csv"]):
        refused(*command)


@pytest.fixture
def stopped_run(tmp_path, monkeypatch):
    """(the steps of an undisturbed run, the checkpoint of one that was stopped: out.h5)."""
    from hpc_gfmd.parallel.interrupt import Interrupt
    from hpc_gfmd.runs.simulation import run_scene
    from hpc_gfmd.scene import Scene

    monkeypatch.setattr(Interrupt, "require_time", lambda self: None)
    tables = {"surface": rough((1, 16, 2)), "load": {"p_star": 0.1}}
    whole = run_scene(Scene.from_dict(tables), out="whole.h5", quiet=True)
    stopped = Scene.from_dict(tables | {"machine": {"wall_seconds": 1e-9}})
    assert run_scene(stopped, out="out.h5", quiet=True).status == "interrupted"
    return whole.steps, tmp_path / "out.h5.partial" / "checkpoint.h5"


@pytest.mark.parametrize("damage", ["cut", "garbled"])
def test_a_bad_checkpoint_is_never_used(damage, stopped_run, capfd):
    """The load starts again, and ends as if there had been no checkpoint."""
    from hpc_gfmd.runs.simulation import restart

    steps, path = stopped_run
    data = path.read_bytes()
    if damage == "cut":
        cut(path, data, 0.7)
    else:
        place = data.index(b"OHDR") + 30
        path.write_bytes(data[:place] + b"\x55" * 64 + data[place + 64 :])
    capfd.readouterr()
    run = restart("out.h5", ["machine.wall_seconds=1e9"])
    (line,) = (line for line in capfd.readouterr().out.splitlines() if "damaged" in line)
    assert line.endswith("load 1 begins anew")
    assert run.exit_code == 0
    assert [step["a_r"] for step in run.steps] == [step["a_r"] for step in steps]
    assert [step["iterations"] for step in run.steps] == [step["iterations"] for step in steps]
