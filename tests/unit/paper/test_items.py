"""Figures, tables and studies of the paper: each tabulates, draws and compares; one command makes
all; errata are what they claim."""

import json
import re
import shutil

import numpy as np
import pytest
from paper import __main__ as command
from paper.cases import Store, cases_of
from paper.errata import ERRATA, dynamics, formulas
from paper.items import STUDIES, TEXTS
from paper.rows import PRESSURES, as_csv, read_csv
from paper_runs import runs_of

import hpc_gfmd
from hpc_gfmd.commands.cli import main
from hpc_gfmd.plotting import style
from hpc_gfmd.theory import persson, tfc

PNG = b"\x89PNG\r\n"
SPECIAL = ("distributions", "percolation", "stiffness")  # need real runs


def paper(*args):
    """Run `python scripts/paper`, which has to succeed."""
    assert main(list(map(str, args)), command.make_parser) == 0


@pytest.fixture(scope="module", autouse=True)
def _low_resolution():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(style.RC, "savefig.dpi", 60)
        yield


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """The folder with all items at the quick level."""
    folder = tmp_path_factory.mktemp("quick")
    table = folder / "ours.json"
    paper(*SPECIAL, "limit", "all", "-o", folder, "--coefficients", table)
    return folder


@pytest.mark.slow
def test_one_command_makes_all_items(quick):
    text = (quick / "README.md").read_text()
    made = [name for name, of in TEXTS.items() if "question" not in of] + [*SPECIAL, "limit"]
    assert set(re.findall(r"\]\((\w+)\.md\)", text)) == {*made, "errata"}
    assert len(list(Store(quick).stored().values())) == int(re.search(r"(\d+) loads", text)[1])
    errata = (quick / "errata.md").read_text()
    assert len(re.findall(r"^\| \d+ \|", errata, re.MULTILINE)) == len(ERRATA) == 25
    text += errata
    for name in made:
        page = (quick / f"{name}.md").read_text()
        assert f"python scripts/paper {name} --level quick" in page
        for link in (f"{name}.png", f"{name}.csv"):
            assert f"]({link})" in page
            assert (quick / link).stat().st_size > 100
        if name in ("distributions", "stiffness", "limit"):
            assert page.count("\n| ") >= 3
        text += page
    assert "nan" not in re.sub(r"[a-zA-Z]nan|nan[a-zA-Z]", "", text)


@pytest.mark.slow
def test_pages_agree_on_the_limit(quick):
    """Table 5, the errata and the page of the limit show the same kappa."""
    limit, table5 = (read_csv((quick / f"{name}.csv").read_text()) for name in ("limit", "table5"))
    for limit_row, table_row in zip(limit, table5, strict=True):  # fitted twice
        for name, value in limit_row.items():
            assert table_row[name] == (
                pytest.approx(value, rel=1e-5) if isinstance(value, float) else value
            )
    ours = [row for row in limit if row["area"] == "ours"]
    assert len(ours) == 8
    text = (quick / "errata.md").read_text()
    shown = re.search(r"ours in the limit: ([\d.]+)", text)[1]
    assert float(shown) == pytest.approx(ours[0]["kappa_tfc"], abs=0.01)
    assert shown in (quick / "limit.md").read_text()


@pytest.mark.slow
def test_rendered_again_without_solving(quick, tmp_path):
    shutil.copy(quick / "runs.jsonl", tmp_path)
    paper("fig6", "table1", "--no-run", "-o", tmp_path)
    for name in ("fig6.csv", "table1.csv", "runs.jsonl"):
        assert (tmp_path / name).read_bytes() == (quick / name).read_bytes()
    table = tfc.read_table(quick / "ours.json")
    system = (0.8, 0.007, 0.5, 1 / 32, 0.5)
    value, sigma, _ = tfc.extrapolate(2.6, "kappa", *system, table=table)
    assert 1.0 < value < 2.6
    assert sigma > 0


@pytest.mark.slow
def test_physics_at_the_quick_level(quick):
    """Trends of the paper hold in small systems: the edge correction shrinks the area, and theory
    is near."""
    for row in read_csv((quick / "fig1.csv").read_text()):
        assert persson.kappa(row["p_star"]) < row["kappa_edge"] < row["kappa"]
    for row in read_csv((quick / "fig6.csv").read_text()):
        assert 0.7 < row["over_persson"] < 1.5
        assert row["over_persson_printed"] > row["over_persson"]
    for row in read_csv((quick / "limit.csv").read_text())[7:]:
        assert abs(row["counted"] - row["edge"]) < 4 * row["kappa_tfc_se"]


@pytest.mark.parametrize("name", [name for name in STUDIES if name not in SPECIAL])
def test_items_from_made_up_runs(name, tmp_path):
    """Made-up runs give rows, a comparison and a picture; so do two runs alone."""
    study = STUDIES[name]
    runs = runs_of(cases_of(name, "quick"), noise=0.01)
    rows = study.tabulate(runs, "quick")
    assert as_csv(rows).count("\n") == len(rows) + 1 > 1
    json.dumps(rows, allow_nan=False)
    for line in study.compare(rows):
        assert set(line) == {"paper", "ours", "why"}
        assert "nan" not in line["ours"]
    one_surface = [run for run in runs if run["seed"] == 1 and run["hurst"] == runs[-1]["hurst"]]
    for table in (rows, study.tabulate(one_surface[:2], "quick")):
        study.draw(table, tmp_path / "picture.png")
        list(study.compare(table))
        assert (tmp_path / "picture.png").read_bytes().startswith(PNG)


def test_pages_without_any_run(tmp_path):
    paper("all", "--no-run", "-o", tmp_path)
    text = (tmp_path / "README.md").read_text()
    assert ".md)" not in text.replace("errata.md", "")
    assert "0 loads" in text


def test_dynamics_as_printed_diverges():
    right = dynamics.gfmd()
    damping = dynamics.gfmd(damping=+1)
    load = dynamics.gfmd(load=+1)
    assert right["speed"][-1] < 1e-3 * right["speed"][0]
    assert damping["speed"][-1] > 1e3 * damping["speed"][0]
    assert load["gap"][-1] > load["gap"][0]
    assert load["a_r"] == 0
    assert dynamics.gfmd(lifted=True)["gap"][-1] == pytest.approx(right["gap"][-1], rel=1e-3)


@pytest.mark.slow
def test_dynamics_reaches_the_contact_of_the_solver():
    """The dynamics of the errata ends where the solver does."""
    z = dynamics.small_surface()
    options = {"E_star": 2.0, "physical_sizes": (2 * np.pi, 2 * np.pi), "accuracy": 1e-6}
    solved = hpc_gfmd.solve(z, p_star=0.1, **options)
    relaxed = dynamics.gfmd(steps=3000)
    assert relaxed["gap"][-1] == pytest.approx(solved.gap_mean, rel=1e-3)
    assert relaxed["a_r"] == pytest.approx(solved.a_r, abs=2.5 / z.size)


def test_formulas_in_the_errata():
    for p_star in PRESSURES.values():
        direct = formulas.gap_from_energy(p_star, 0.8, 1 / 256, 0.42)
        assert direct == pytest.approx(float(persson.mean_gap(p_star, 0.8, 1 / 256)), rel=1e-8)
        assert direct > 1.1 * float(persson.mean_gap(p_star, 0.8, 1 / 256, printed=True))
    for show, expected in (
        (formulas.parseval, "1.000000000000"),
        (formulas.height_scale, "0.500000 of the printed height, 1.000000 of the printed slope"),
        (formulas.scaling, "right 1.5, printed 0"),
        (formulas.inverted_ratio, "8192 points"),
    ):
        assert expected in show({})
