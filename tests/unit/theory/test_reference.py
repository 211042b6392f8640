"""Reference curves as loaded by a user, and how their file is made from stored runs."""

import json

import numpy as np
import pytest
from paper.cases import series
from paper.items import curves
from paper_runs import runs_of
from refusal import refused

from hpc_gfmd import reference
from hpc_gfmd.theory import persson

# ratios of the made-up runs to theory at H = 0
AREA = 1.3
GAP = 0.8


def fake_runs(scatter=0.01):
    """Runs with AREA + 0.1 H times Persson's area and GAP times his gap.

    At large pressures the area is Persson's, and the gap is closed from p* = 1.4 on.
    """
    runs = []
    for run in runs_of(
        series("curves", "quick"), scatter=scatter, kappa=lambda case, t, f, c: (1 + c, 1 + 0.2 * c)
    ):
        p_star = run["p_star"]
        surface = (run["hurst"], run["eps_f"])
        ratio = AREA + 0.1 * run["hurst"] if p_star < 0.5 else 1.0
        area = ratio * persson.contact_area(p_star)
        scatter_of_run = run["kappa_edge"] / (1 + 0.2 * run["eps_c"])
        gap = GAP * persson.mean_gap(p_star, *surface) * scatter_of_run if p_star < 1.4 else 0.0
        changed = {
            "kappa": run["kappa"] * area / p_star,
            "kappa_edge": run["kappa_edge"] * area / p_star,
            "gap_over_h_rms": float(gap),
        }
        runs.append(run | changed)
    return runs


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("reference") / "reference.json"
    path.write_text(curves.reference_data(fake_runs(), "quick"))
    return path


def test_values_uncertainties_and_provenance(written):
    loaded = reference.load(written)
    assert loaded.hurst.tolist() == [0.3, 0.8]
    assert loaded.eps_f.tolist() == [0.25]
    assert loaded.p_star["a_r"].tolist() == list(curves.LOADS)
    assert loaded.p_star["gap_over_h_rms"].tolist() == [p for p in curves.LOADS if p < 1.4]
    for hurst in (0.3, 0.8):
        a_r, sigma = loaded.at("a_r", curves.LOADS[2], hurst, 0.25)
        assert (
            abs(a_r / persson.contact_area(curves.LOADS[2]) - AREA - 0.1 * hurst)
            < 4 * sigma / a_r
            < 0.15
        )
    assert loaded.provenance["accuracy"] == [1e-3]
    assert {"command", "level", "date", "runs", "versions"} <= set(loaded.provenance)
    assert written.stat().st_size < 1e6
    assert "The mean gap ends at p_star = 1:" in json.loads(written.read_text())["note"]


def test_interpolation(written):
    loaded = reference.load(written)
    for p_star, value, sigma in zip(
        loaded.p_star["a_r"], loaded.value["a_r"][1, 0], loaded.sigma["a_r"][1, 0], strict=True
    ):
        assert loaded.at("a_r", p_star, 0.8, 0.25) == pytest.approx(
            (value, value * sigma), rel=1e-9
        )
    dense = np.geomspace(1e-4, 0.3, 200)
    values, sigma = loaded.at("a_r", dense, 0.55, 0.25)
    assert values.shape == sigma.shape == (200,)
    assert np.all(np.diff(values) > 0)
    assert np.abs(values / persson.contact_area(dense) / (AREA + 0.055) - 1).max() < 0.05


OUT_OF_RANGE = [
    (("a_r", 3.0, 0.8, 0.25), r"p_star: found 3, allowed: \[0\.0001, 2\]"),
    (("a_r", [0.1, 1e-5], 0.8, 0.25), "p_star: found"),
    (("gap_over_h_rms", 1.5, 0.8, 0.25), r"allowed: \[0\.0001, 1\]"),
    (("a_r", 0.1, 0.2, 0.25), r"hurst: found 0\.2, allowed: \[0\.3, 0\.8\]"),
    (("a_r", 0.1, 0.5, 0.1), "eps_f: found 0.1"),
    (("a_r", 0.1, float("nan"), 0.25), "hurst"),
    (("gap", 0.1, 0.5, 0.25), "quantity"),
]


def test_out_of_range_is_refused(written):
    for arguments, words in OUT_OF_RANGE:
        with refused(words):
            reference.load(written).at(*arguments)


def test_missing_runs_and_damaged_files_are_refused(written, tmp_path):
    with refused("found no curves"):
        curves.reference_data([], "quick")
    data = json.loads(written.read_text())
    data["value"]["a_r"][0][0].pop()
    for text in ("", "{}", "[]", '{"format": "other"}', json.dumps(data)):
        (tmp_path / "bad.json").write_text(text)
        for path in (tmp_path / "bad.json", ""):
            with refused("reference: found"):
                reference.load(path)


def test_shipped_data():
    shipped = reference.load()
    assert shipped.provenance["level"] == "desk"
    assert shipped.hurst.tolist() == [0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 1.0]
    assert shipped.eps_f == pytest.approx([1 / 256, 1 / 64, 1 / 16])
    assert (shipped.p_star["a_r"][0], shipped.p_star["a_r"][-1]) == (1e-4, 2.0)
    dense = np.geomspace(1e-3, 0.9, 60)
    for hurst in (0.1, 0.42, 0.8, 1.0):
        for eps_f in (1 / 256, 1 / 100, 1 / 16):
            (a_r, a_sigma), (gap, gap_sigma) = (
                of(dense, hurst, eps_f) for of in (reference.contact_area, reference.mean_gap)
            )
            assert np.all(np.diff(a_r) > 0)
            assert np.all(np.diff(gap) < 0)
            assert np.all((a_r > persson.contact_area(dense)) & (a_r < 2.7 * dense))
            assert np.all((a_sigma > 0) & (a_sigma < 0.15 * a_r))
            assert np.all((gap_sigma > 0) & (gap_sigma < 0.15 * gap))
    assert reference.contact_area(2.0, 0.8, 1 / 64)[0] == pytest.approx(1, abs=1e-3)


def test_units_of_the_gap():
    in_h_rms, in_slopes = (
        reference.mean_gap(0.1, 0.8, 1 / 256, unit)[0] for unit in ("h_rms", "g_rms_lam_s")
    )
    assert in_h_rms / in_slopes == pytest.approx(persson.g_rms_lam_s_over_h_rms(0.8, 1 / 256))
    with refused("unit"):
        reference.mean_gap(0.1, 0.8, 1 / 256, unit="h")
