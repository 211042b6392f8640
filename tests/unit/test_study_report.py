"""The report: one command makes it from nothing at the quick level; every study tabulates and
draws; the errata are what they claim."""

import json
import re

import numpy as np
import pytest
from paper import catalogue, report
from paper.command import make_parser
from paper.errata import dynamics, formulas
from paper.levels import P_HIGH, P_LOW
from paper.publish import as_csv
from paper.store import Store
from study_runs import runs_of

from hpc_gfmd.commands.cli import main
from hpc_gfmd.plotting import style
from hpc_gfmd.theory import persson, tfc

PNG = b"\x89PNG\r\n"
STUDIES = [catalogue.study(name) for name in catalogue.of_paper()]


@pytest.fixture(scope="module", autouse=True)
def _coarse_pictures():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(style.RC, "savefig.dpi", 60)
        yield


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """The folder that `python scripts/paper all --level quick` makes."""
    folder = tmp_path_factory.mktemp("quick")
    assert main(["all", "--level", "quick", "-o", str(folder)], make_parser) == 0
    return folder


@pytest.fixture(scope="module")
def text(quick):
    return (quick / report.FILE).read_text()


def test_everything_that_the_report_names_is_there(quick, text):
    links = re.findall(r"\]\(([^)]+)\)", text)
    assert {f"{study.name}.{ending}" for study in STUDIES for ending in ("png", "csv", "json")} | {
        report.OUR_TABLE
    } == set(links)
    for link in set(links):
        assert (quick / link).stat().st_size > 100
    for study in STUDIES:
        assert (quick / f"{study.name}.png").read_bytes().startswith(PNG)


def test_report_is_complete(quick, text):
    for heading in (
        "Open questions",
        "kappa in the TFC limit",
        "The exponent alpha_c",
        "Theory is 2 to 3 times",
        "Errata",
        "Paper says / we find / why",
    ):
        assert heading in text
    assert "nan" not in re.sub(r"[a-zA-Z]nan|nan[a-zA-Z]", "", text)
    assert "not yet" not in text
    assert len(Store(quick).load()) == int(re.search(r"(\d+) loads", text)[1])
    limits = text.partition("### kappa in the TFC limit")[2].partition("###")[0]
    assert len(re.findall(r"^\| 0", limits, re.MULTILINE)) == 8
    errata = text.partition("## Errata of the paper")[2]
    assert len(re.findall(r"^\| \d+ \|", errata, re.MULTILINE)) == len(report.ERRATA) == 25


def test_numbers_come_from_the_rows(quick, text):
    """What stands in the report is in the tables: the theory factors, to all their digits."""
    rows = json.loads((quick / "fig6.json").read_text())["rows"]
    section = text.partition("Theory is 2 to 3 times")[2].partition("##")[0]
    lines = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in section.splitlines()
        if line.startswith("| 0")
    ]
    assert lines
    for hurst, p_star, eps_f, _, printed, corrected, *_ in lines:
        row = next(
            r
            for r in rows
            if (f"{r['hurst']:g}", f"{r['p_star']:.3f}", f"1/{1 / r['eps_f']:g}")
            == (hurst, p_star, eps_f)
        )
        assert (f"{row['over_persson_printed']:.3f}", f"{row['over_persson']:.3f}") == (
            printed,
            corrected,
        )
        theory = float(persson.mean_gap(row["p_star"], row["hurst"], row["eps_f"]))
        assert row["over_persson"] == pytest.approx(row["gap_over_h_rms"] / theory)


def test_rendered_again_without_solving(quick, text):
    before = (quick / "runs.jsonl").read_bytes()
    assert report.report(quick, "quick") == quick / report.FILE
    assert (quick / "runs.jsonl").read_bytes() == before
    assert (quick / report.FILE).read_text() == text


def test_our_coefficients(quick):
    table = tfc.read_table(quick / report.OUR_TABLE)
    value, sigma, _ = tfc.extrapolate(2.6, "kappa", 0.8, 0.007, 0.5, 1 / 32, 0.5, table=table)
    assert 1.0 < value < 2.6
    assert sigma > 0


def test_physics_at_the_quick_level(quick):
    """Scaled down as it is, it shows what the paper shows: kappa falls with eps_c, the correction
    shrinks the area, theory is near."""
    rows = {
        study.name: json.loads((quick / f"{study.name}.json").read_text())["rows"]
        for study in STUDIES
    }
    for row in rows["fig1"]:
        assert persson.kappa(row["p_star"]) < row["kappa_edge"] < row["kappa"]
    assert all(0.7 < row["over_persson"] < 1.5 for row in rows["fig6"])
    assert all(row["over_persson_printed"] > row["over_persson"] for row in rows["fig6"])
    for row in rows["table5"]:
        if row["area"] == "edge":
            assert abs(row["difference"]) < 4 * row["difference_se"]


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_studies_from_made_up_runs(study, tmp_path):
    """From other numbers than the solver's rows with errors and a comparison of three columns, from
    next to none a picture."""
    runs = runs_of(study.cases("quick"))
    rows = study.tabulate(runs, "quick")
    assert rows
    assert as_csv(rows).count("\n") == len(rows) + 1
    json.dumps(rows, allow_nan=False)
    for line in study.compare(rows):
        assert set(line) == {"paper", "ours", "why"}
        assert "nan" not in line["ours"]
    few = study.tabulate(
        [run for run in runs if run["seed"] == 1 and run["hurst"] == runs[-1]["hurst"]][:2], "quick"
    )
    study.draw(few, tmp_path / "few.png")
    study.compare(few)
    assert (tmp_path / "few.png").read_bytes().startswith(PNG)


def test_nothing_solved_yet(tmp_path):
    text = report.report(tmp_path, "quick").read_text()
    assert "Nothing solved yet" in text
    assert "0 loads" in text


def test_dynamics_as_printed_and_as_it_should_be():
    right, damping, load = dynamics.gfmd(), dynamics.gfmd(damping=+1), dynamics.gfmd(load=+1)
    assert right["speed"][-1] < 1e-3 * right["speed"][0]
    assert damping["speed"][-1] > 1e3 * damping["speed"][0]
    assert load["gap"][-1] > load["gap"][0]
    assert load["a_r"] == 0
    assert dynamics.gfmd(lifted=True)["gap"][-1] == pytest.approx(right["gap"][-1], rel=1e-3)


def test_dynamics_finds_the_contact():
    """The small contact of the errata, against the solver."""
    import hpc_gfmd

    z = dynamics.small_surface()
    n = len(z)
    q = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(n, 1 / n)], indexing="ij"))
    g_rms = np.sqrt(np.sum(q**2 * np.abs(np.fft.fft2(z) / z.size) ** 2))
    solved = hpc_gfmd.solve(
        z, 0.2 * g_rms, E_star=2.0, physical_sizes=(2 * np.pi, 2 * np.pi), accuracy=1e-6
    )
    found = dynamics.gfmd(steps=3000)
    assert found["gap"][-1] == pytest.approx(solved.gap_mean, rel=1e-3)
    assert found["a_r"] == pytest.approx(solved.a_r, abs=2.5 / z.size)


def test_missing_factor_by_quadrature():
    for p_star in (P_LOW, P_HIGH):
        direct = formulas.gap_from_energy(p_star, 0.8, 1 / 256, 0.42)
        assert direct == pytest.approx(float(persson.mean_gap(p_star, 0.8, 1 / 256)), rel=1e-8)
        assert direct > 1.1 * float(persson.mean_gap(p_star, 0.8, 1 / 256, printed=True))


def test_formulas_in_the_errata():
    assert "1.000000000000" in formulas.parseval()
    assert (
        "0.500000 of the printed height, 1.000000 of the printed slope" in formulas.height_scale()
    )
    assert "right 1.5, printed 0" in formulas.scaling()
    assert "8192 points" in formulas.inverted_ratio()
