"""Means and scatter of several results, in memory, from files and by commands."""

import numpy as np
import pytest
from contacts import rough_wall

import hpc_gfmd
from hpc_gfmd.util.errors import SceneError

LOADS = [0.05, 0.2]


def solved(seed, loads=LOADS, **arguments):
    """Solutions of a small wall; arguments: of hpc_gfmd.solve."""
    wall = rough_wall((1, 8, 2), seed=seed)
    return hpc_gfmd.solve(wall, p_star=loads, fields=(), **arguments)


@pytest.fixture(scope="module")
def results():
    return [solved(seed, observables=["patches"]) for seed in range(3)]


def test_mean_and_scatter_are_those_of_the_results(results):
    ensemble = hpc_gfmd.Ensemble(results)
    areas = np.array([result.a_r for result in results])
    np.testing.assert_allclose(ensemble.mean("a_r"), areas.mean(axis=0))
    np.testing.assert_allclose(ensemble.std("a_r"), areas.std(axis=0, ddof=1))
    table = ensemble.to_dataframe()
    np.testing.assert_allclose(table["gap_mean_std"], ensemble.std("gap_mean"))
    np.testing.assert_allclose(ensemble.loads, LOADS)
    assert ensemble.load in ("p", "p_star")


def test_leak_rate_has_the_scatter_and_the_error_of_the_grid():
    """Rates go with the cube of the critical gap; a seal that is tight has an infinite error."""
    loads = [0.02, 0.1, 1.0]
    seals = [solved(seed, loads, observables=["critical_gap"]) for seed in range(3)]
    ensemble = hpc_gfmd.Ensemble(seals)
    rates = np.array([seal.leak_rate(1e-3, "1 bar", "30 cm", "1 mm") for seal in seals])
    np.testing.assert_allclose(
        ensemble.leak_rate(1e-3, "1 bar", "30 cm", "1 mm"), rates.mean(axis=0)
    )
    of_grid = np.array([seal.leak_rate_error() for seal in seals])
    scatter = rates.std(axis=0, ddof=1) / rates.mean(axis=0).clip(1e-300)
    error = ensemble.leak_rate_error()
    mean_of_grid = (rates * of_grid)[:, 0].mean() / rates[:, 0].mean()
    assert error[0] == pytest.approx(np.hypot(scatter[0], mean_of_grid))
    assert error[0] > scatter[0] > 0
    assert rates[:, -1].max() == 0
    assert error[-1] == np.inf
    heading, _, first, *_ = ensemble.table().splitlines()
    assert "critical_gap_x  critical_gap_y" in heading
    assert f"{ensemble.mean('critical_gap_y')[0]:.1g}" in first


def test_table_and_plot(results):
    ensemble = hpc_gfmd.Ensemble(results)
    text = ensemble.table()
    assert len(text.splitlines()) == 2 + len(LOADS) + 1
    assert "patches" in text.splitlines()[0]
    assert "+-" in text.splitlines()[2]
    assert "<table" in ensemble._repr_html_()
    assert len(ensemble.plot("a_r").axes) == 1


def test_loads_that_are_not_converged_are_named(results):
    short = {"max_iterations": 1, "nested": False}
    with pytest.warns(hpc_gfmd.NotConverged):
        failed = solved(7, **short)
    ensemble = hpc_gfmd.Ensemble([results[0], failed])
    assert ensemble.table().endswith(
        "NOT CONVERGED: 1 of 2 results at load 0, 1 of 2 results at load 1"
    )
    assert "NOT CONVERGED" not in hpc_gfmd.Ensemble(results).table()


def test_show_and_plot_several_files(results, cli, tmp_path):
    paths = [result.save(tmp_path / f"{k}.h5") for k, result in enumerate(results)]
    assert "3 results" in cli.prints("show", *paths)
    data = cli.data("show", *paths)
    ensemble = hpc_gfmd.Ensemble(results)
    np.testing.assert_allclose(data["loads"]["a_r_std"], ensemble.std("a_r"))
    picture = tmp_path / "together.png"
    assert str(picture) in cli.prints("plot", *paths, "--what", "a_r", "-o", picture)
    assert picture.stat().st_size > 1000
    assert "--json" in cli.refused("show", *paths, "--errors")
    assert "single file" in cli.refused("plot", *paths, "--step", "0")


def test_results_that_do_not_match_are_refused(results):
    with pytest.raises(SceneError, match="two or more"):
        hpc_gfmd.Ensemble(results[:1])
    with pytest.raises(SceneError, match="2, 3 loads"):
        hpc_gfmd.Ensemble([results[0], solved(5, [0.05, 0.1, 0.2])])
    with pytest.raises(SceneError, match="different loads"):
        hpc_gfmd.Ensemble([results[0], solved(5, [0.05, 0.3])])
    with pytest.raises(SceneError, match="result 2 is an error"):
        hpc_gfmd.Ensemble([results[0], SceneError("a wall")])
    with pytest.raises(SceneError, match="'status', which is no number"):
        hpc_gfmd.Ensemble(results).mean("status")
