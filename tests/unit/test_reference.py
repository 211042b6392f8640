"""Reference curves: what a user loads, and the file that is made from stored runs."""

import json
import subprocess
import sys

import numpy as np
import pytest
from mpi_harness import environment

from hpc_gfmd import reference
from hpc_gfmd.errors import SceneError
from hpc_gfmd.study.levels import gap_pressure_series, level_of
from hpc_gfmd.study.reference_data import write_reference
from hpc_gfmd.study.store import Store
from hpc_gfmd.theory import persson


def fake_run(case, p_star, factor):
    """A stored run with Persson's area and a gap that falls with p_star; factor: of this realisation."""
    a_r = min(1.0, persson.contact_area(p_star) * factor)
    gap = 0.0 if p_star > 1.9 else 0.3 * np.exp(-3 * p_star) * factor
    return {name: getattr(case, name) for name in ("hurst", "L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a", "n", "seed",
                                                   "accuracy", "eps_t", "eps_f", "eps_c")} | {
        "p_star": p_star, "a_r": a_r, "a_r_edge": 0.98 * a_r, "gap_over_h_rms": gap, "gap_over_g_rms_lam_s": 2 * gap,
        "kappa": a_r / p_star, "a_r_error": 1e-4, "gap_error": 1e-4, "status": "converged", "version": "0.1.0"}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reference")
    store = Store(folder)
    for case in gap_pressure_series("quick"):
        for p_star in case.p_star:
            store.append(fake_run(case, p_star, 1 + 0.01 * (-1) ** case.seed))
    write_reference(folder / "reference.json", store, "quick")
    return folder / "reference.json"


def test_means_uncertainties_and_provenance(written):
    found = reference.load(written)
    curve = found.curve(0.8, 1 / 16)
    assert curve.seeds == (1, 2)
    assert curve.p_star.tolist() == list(level_of("quick").loads)
    assert curve.a_r[:3] == pytest.approx([persson.contact_area(p) for p in curve.p_star[:3]], rel=1e-5)
    assert np.all(curve.sigma["a_r"][:3] / curve.a_r[:3] == pytest.approx(0.01, rel=0.02))  # two values 1 % off their mean
    assert found.provenance["versions"] == ["0.1.0"]
    assert found.provenance["accuracy"] == [1e-3]
    assert {"command", "level", "date", "runs"} <= set(found.provenance)
    assert {c.hurst for c in found.curves} == {0.3, 0.5, 0.8}


def test_interpolation(written):
    curve = reference.load(written).curve(0.5, 1 / 32)
    for p_star, value, sigma in zip(curve.p_star, curve.a_r, curve.sigma["a_r"], strict=True):
        assert curve.at(p_star, "a_r") == pytest.approx((value, sigma), rel=1e-9)
    dense = np.geomspace(curve.p_star[0], curve.p_star[-1], 200)
    values, sigma = curve.at(dense, "a_r")
    assert values.shape == sigma.shape == (200,)
    assert np.all(np.diff(values) >= 0)
    assert np.abs(values / persson.contact_area(dense) - 1).max() < 0.05
    with pytest.raises(SceneError, match=r"p_star: found 2\.0, allowed: from 0\.004 to 1"):
        curve.at(2.0, "gap_over_h_rms")  # closed: there is no gap whose logarithm could be taken
    with pytest.raises(SceneError, match="p_star"):
        curve.at([0.1, 1e-5], "a_r")
    with pytest.raises(SceneError, match="quantity"):
        curve.at(0.1, "gap")


def test_refused(written, tmp_path):
    found = reference.load(written)
    with pytest.raises(SceneError, match=r"allowed for hurst = 0\.8: 1/16, 1/32, 1/8"):
        found.curve(0.8, 0.3)
    with pytest.raises(SceneError, match=r"hurst: found 0\.7, allowed: 0\.3, 0\.5, 0\.8"):
        found.curve(0.7, 1 / 16)
    with pytest.raises(SceneError, match="no sweep of level quick"):
        write_reference(tmp_path / "x.json", Store(tmp_path), "quick")
    data = json.loads(written.read_text())
    data["curves"][0]["a_r"].pop()
    for text in ("", "{}", "[]", '{"format": "other"}', json.dumps(data)):
        (tmp_path / "bad.json").write_text(text)
        with pytest.raises(SceneError, match="reference: found"):
            reference.load(tmp_path / "bad.json")


def test_shipped_data():
    shipped = reference.load()
    assert shipped.provenance["level"] == "desk"
    assert {curve.hurst for curve in shipped.curves} == {0.0, 0.3, 0.5, 0.8}
    for curve in shipped.curves:
        assert np.all(np.diff(curve.a_r) >= 0)
        assert np.all(np.diff(curve.gap_over_h_rms) <= 0)
        low = curve.p_star < 0.05
        assert np.all((curve.a_r_edge[low] > persson.contact_area(curve.p_star[low])) & (curve.a_r_edge[low] < 2.6 * curve.p_star[low]))
        assert np.all((curve.sigma["a_r"] >= 0) & (curve.sigma["a_r"] < 0.1 * curve.a_r))
        a_r, sigma = reference.contact_area(0.1, curve.hurst, curve.eps_f)
        assert 0.16 < a_r < 0.22
        assert 0 < sigma < 0.01
        assert reference.mean_gap(0.1, curve.hurst, curve.eps_f)[0] > 0
    with pytest.raises(SceneError, match="quantity"):
        reference.mean_gap(0.1, 0.8, 1 / 256, unit="h")


def test_reading_needs_no_kernels_and_no_mpi():
    code = ("import sys; from hpc_gfmd import reference; reference.contact_area(0.1, 0.8, 1/256); "
            "print(sorted({'numba', 'mpi4py', 'h5py'} & set(sys.modules)))")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment(), check=True)
    assert done.stdout.strip() == "[]"
