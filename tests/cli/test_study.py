"""`hpc-gfmd study` as a user sees it."""

import csv
import json
from types import SimpleNamespace

import pytest

from hpc_gfmd.cli import main
from hpc_gfmd.study.store import Store


@pytest.fixture
def cli(monkeypatch, capfd, tmp_path):
    """cli(*args): one command in this process, in a folder of its own; its exit code and texts."""
    monkeypatch.chdir(tmp_path)

    def run(*args):
        capfd.readouterr()
        code = main(["study", *args])
        return SimpleNamespace(code=code, **capfd.readouterr()._asdict())

    return run


@pytest.mark.parametrize(("args", "said"), [
    (["fig14"], "nearest: 'fig"), (["tabel3"], "nearest: 'table3'"), ([], "NAME: found nothing"), (["fig1", "--level", "big"], "desk"),
    (["fig1", "--part", "3/2", "--only-run"], "--part: found '3/2'"), (["fig1", "--part", "1/2"], "--only-run"),
    (["fig1", "--threads", "0"], "--threads: found '0'"), (["fig1", "--only-run", "--no-run"], "not allowed"),
    (["fig1", "--only-run", "--report"], "--only-run: found with"),
])
def test_wrong_arguments(cli, args, said):
    run = cli(*args)
    assert run.code == 2
    assert said in run.err
    assert run.err.count("\n") == 1


def test_list(cli):
    lines = cli("--list").out.splitlines()
    assert (len(lines), lines[0].split()[0], lines[17].split()[0], lines[-1].split()[0]) == (23, "fig1", "table5", "stiffness")


def test_plan_solves_nothing(cli, tmp_path):
    run = cli("all", "--level", "desk", "--plan")
    assert run.code == 0
    assert "to solve" in run.out
    assert not list(tmp_path.iterdir())


def test_figure_from_nothing_and_again(cli, tmp_path):
    run = cli("fig13")
    assert run.code == 0, run.err
    folder = tmp_path / "study-quick"
    assert {"fig13.csv", "fig13.json", "fig13.png", "runs.jsonl"} <= {path.name for path in folder.iterdir()}
    rows = json.loads((folder / "fig13.json").read_text())["rows"]
    with open(folder / "fig13.csv") as file:
        assert len(list(csv.DictReader(file))) == len(rows) > 10
    before = (folder / "runs.jsonl").read_bytes()
    again = cli("fig13", "--no-run")
    assert again.code == 0
    assert (folder / "runs.jsonl").read_bytes() == before
    assert json.loads((folder / "fig13.json").read_text())["rows"] == rows


def test_nothing_stored(cli):
    run = cli("fig13", "--no-run", "-o", "empty")
    assert (run.code, "nothing stored yet" in run.out) == (0, True)


def test_parts_make_the_whole(cli, tmp_path):
    for part in ("1/2", "2/2"):
        assert cli("fig13", "--only-run", "--part", part, "-o", "parts").code == 0
    assert {path.name for path in (tmp_path / "parts").iterdir()} == {"runs-1.jsonl", "runs-2.jsonl"}
    run = cli("fig13", "--only-run", "-o", "parts")
    assert "to solve" not in run.out  # nothing is left
    assert len(Store(tmp_path / "parts").load()) == sum(
        len((tmp_path / "parts" / name).read_text().splitlines()) for name in ("runs-1.jsonl", "runs-2.jsonl"))
