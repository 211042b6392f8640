"""Figures, tables and studies of the paper: each tabulates, draws and compares; one command makes
all; errata are what they claim."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from paper import __main__ as command
from paper.cases import Store
from paper.errata import ERRATA, dynamics, formulas
from paper.items import STUDIES, TEXTS
from paper.rows import PRESSURES
from unit.test_page_code import agree

import hpc_gfmd
from hpc_gfmd.commands.cli import main
from hpc_gfmd.plotting import style
from hpc_gfmd.theory import persson, tfc

STUDY = Path(__file__).parents[3] / "docs" / "study"
SPECIAL = ("distributions", "percolation", "stiffness")  # need real runs


def paper(*args):
    """Run `python scripts/paper`, which has to succeed."""
    assert main(list(map(str, args)), command.make_parser) == 0


@pytest.fixture(scope="module", autouse=True)
def _low_resolution():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(style.RC, "savefig.dpi", 60)
        yield


@pytest.mark.slow
def test_one_command_makes_all_items(tmp_path):
    quick = tmp_path
    paper(*SPECIAL, "limit", "all", "-o", quick, "--coefficients", quick / "ours.json")
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
    table = tfc.read_table(quick / "ours.json")
    system = (0.8, 0.007, 0.5, 1 / 32, 0.5)
    value, sigma, _ = tfc.extrapolate(2.6, "kappa", *system, table=table)
    assert 1.0 < value < 2.6
    assert sigma > 0


@pytest.mark.slow
def test_the_study_follows_from_its_runs(tmp_path):
    """Pages of figures and tables, the errata and the limit, from the runs that are kept."""
    shutil.copy(STUDY / "runs.jsonl.gz", tmp_path)
    paper("all", "limit", "--no-run", "--level", "desk", "-o", tmp_path)
    for name in [*STUDIES, "errata"]:
        if name not in (*SPECIAL, "curves"):  # whose runs are those of the level "paper"
            page, kept = ((folder / f"{name}.md").read_text() for folder in (tmp_path, STUDY))
            assert agree(kept, page), name


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
