"""`python scripts/paper` as a user sees it."""

import csv
import json

import pytest
from paper.command import make_parser
from paper.store import Store


@pytest.fixture(autouse=True)
def _paper(cli):
    cli.script = make_parser


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["fig14"], "nearest: 'fig"),
        (["tabel3"], "nearest: 'table3'"),
        ([], "NAME: found nothing"),
        (["fig1", "--level", "big"], "desk"),
        (["fig1", "--part", "3/2", "--only-run"], "--part: found '3/2'"),
        (["fig1", "--part", "1/2"], "--only-run"),
        (["fig1", "--threads", "0"], "--threads: found '0'"),
        (["fig1", "--only-run", "--no-run"], "not allowed"),
        (["fig1", "--only-run", "--report"], "--only-run: found with"),
    ],
)
def test_wrong_arguments(cli, args, said):
    assert said in cli.refused(*args)


def test_list(cli):
    lines = cli.prints("--list").splitlines()
    assert (len(lines), lines[0].split()[0], lines[17].split()[0], lines[-1].split()[0]) == (
        23,
        "fig1",
        "table5",
        "stiffness",
    )


def test_plan_solves_nothing(cli, tmp_path):
    assert "to solve" in cli.prints("all --level desk --plan")
    assert not list(tmp_path.iterdir())


def test_figure_from_nothing_and_again(cli, tmp_path):
    cli.prints("fig13")
    folder = tmp_path / "study-quick"
    assert {"fig13.csv", "fig13.json", "fig13.png", "runs.jsonl"} <= {
        path.name for path in folder.iterdir()
    }
    rows = json.loads((folder / "fig13.json").read_text())["rows"]
    with open(folder / "fig13.csv") as file:
        assert len(list(csv.DictReader(file))) == len(rows) > 10
    before = (folder / "runs.jsonl").read_bytes()
    cli.prints("fig13 --no-run")
    assert (folder / "runs.jsonl").read_bytes() == before
    assert json.loads((folder / "fig13.json").read_text())["rows"] == rows


def test_nothing_stored(cli):
    assert "nothing stored yet" in cli.prints("fig13 --no-run -o empty")


def test_parts_make_the_whole(cli, tmp_path):
    for part in ("1/2", "2/2"):
        cli.prints("fig13 --only-run --part", part, "-o", "parts")
    assert {path.name for path in (tmp_path / "parts").iterdir()} == {
        "runs-1.jsonl",
        "runs-2.jsonl",
    }
    assert "to solve" not in cli.prints("fig13 --only-run -o parts")  # nothing is left
    assert len(Store(tmp_path / "parts").load()) == sum(
        len((tmp_path / "parts" / name).read_text().splitlines())
        for name in ("runs-1.jsonl", "runs-2.jsonl")
    )
