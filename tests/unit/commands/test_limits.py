"""`hpc-gfmd show --tfc`: corrections of a result to the thermodynamic, fractal and continuum
limits."""

from pathlib import Path

import pytest
from refusal import refused

from hpc_gfmd.commands.limits import to_limits
from hpc_gfmd.output.result import Result
from hpc_gfmd.theory import tfc

SURFACE = {"kind": "self-affine", "hurst": 0.8, "eps_t": 0.5, "eps_f": 1 / 1024, "eps_c": 0.5}


def result_of(surface=SURFACE, **step):
    step = {
        "p_star": 0.007,
        "kappa": 2.2,
        "gap_over_h_rms": 1.6,
        "a_r_error": 1e-3,
        "gap_error": 5e-4,
        "status": "converged",
        "note": "\udcff",
    } | step
    return Result(Path("x.h5"), surface, [step], [0], "converged", {}, [])


def test_other_surfaces_are_refused():
    ratios = dict.fromkeys(("eps_t", "eps_f", "eps_c"), float("nan"))
    with refused("'wave'"):
        to_limits(result_of({"kind": "wave"} | ratios))


def test_show_with_tfc(monkeypatch, cli):
    monkeypatch.setattr("hpc_gfmd.output.read.read_result", lambda path: result_of())
    tables = cli.data("show x.h5 --tfc paper")
    assert tables["tfc"]["table"] == "paper"
    kappa = tables["tfc"]["steps"][0]["kappa"]
    assert kappa["extrapolated"] == pytest.approx(2.0160, abs=5e-5)  # eq. tfcArea
    assert kappa["extrapolated_sigma"] == pytest.approx(2.2e-3)
    assert "no uncertainties" in " ".join(kappa["notes"])
    assert set(tables) == {"surface", "steps", "status", "tfc"}
    assert "tfc" not in cli.data("show x.h5")
    for ours in ([], [""]):
        assert "coefficients ours" in cli.prints("show x.h5 --tfc", *ours)
    assert "table: found 'nowhere.json'" in cli.refused("show x.h5 --tfc nowhere.json")
    assert tfc.table_of("paper") == tfc.paper_table() != tfc.our_table() == tfc.table_of("ours")
