"""Corrections to the TFC limits: the paper's tables, refusals, and tables of users."""

import json

import numpy as np
import pytest
from refusal import refused

from hpc_gfmd.theory import tfc

REFERENCE = {"eps_t": 1 / 2, "eps_f": 1 / 1024, "eps_c": 1 / 2}


def test_example_of_the_paper():
    value, sigma, terms = tfc.extrapolate(2.2, "kappa", 0.8, 0.007, **REFERENCE)
    assert value == pytest.approx(2.0160, abs=5e-5)
    assert value == pytest.approx(
        2.2 - 0.0421 / 2 - 8.5879 * 1024**-0.67 - 0.1279 * 0.5**0.67, rel=1e-14
    )
    assert sigma is None
    assert terms.total == pytest.approx(2.2 - value)


def test_rounded_pressures_select_their_table():
    for p_star, table in ((0.01 / np.sqrt(2), 0.007), (0.5 / np.sqrt(2), 0.353), (0.37, 0.353)):
        assert tfc.correction("kappa", 0.5, p_star, **REFERENCE).p_star == table


def test_other_pressures_are_refused():
    for p_star in (0.006, 0.01, 0.05, 0.3, 0.4, 0, np.nan):
        with refused(r"p_star: found .*allowed"):
            tfc.correction("kappa", 0.5, p_star, **REFERENCE)


def test_interpolation_only_in_hurst():
    ends = [
        tfc.correction("gap_over_h_rms", hurst, 0.353, **REFERENCE) for hurst in (0.5, 0.65, 0.8)
    ]
    assert ends[1].f == pytest.approx((ends[0].f + ends[2].f) / 2)
    assert "interpolated" in ends[1].notes[0]
    assert not any("interpolated" in note for note in ends[0].notes)
    for hurst in (0.29, 0.81, 0, 1):
        with refused("hurst: found"):
            tfc.correction("kappa", hurst, 0.007, **REFERENCE)


def test_zero_ratios_and_refused_arguments():
    assert tfc.correction("kappa", 0.8, 0.007, 0, 0, 0).total == 0
    for bad in ({"eps_t": -1}, {"eps_f": np.nan}, {"eps_c": 1.5}):
        with refused(f"{next(iter(bad))}: found"):
            tfc.correction("kappa", 0.8, 0.007, **(REFERENCE | bad))
    with refused("observable: found 'area', allowed: gap_over_h_rms, kappa"):
        tfc.correction("area", 0.8, 0.007, **REFERENCE)


def test_table_of_a_user(tmp_path):
    row = {"hurst": 0.8, "C_t": 0.04, "C_f": 8.0, "C_c": 0.13}
    row |= {"alpha_t": 1.0, "alpha_f": 0.7, "alpha_c": 0.6, "sigma": {"C_c": 0.02, "C_t": 0.01}}
    table = {"tables": [{"observable": "kappa", "p_star": 0.05, "rows": [row]}]}
    (tmp_path / "own.json").write_text(json.dumps(table))
    read = tfc.read_table("own.json")
    value, sigma, terms = tfc.extrapolate(
        2.2, "kappa", 0.8, 0.05, **REFERENCE, sigma=0.01, table=read
    )
    expected = 0.04 / 2 + 8 * 0.5**7 + 0.13 * 0.5**0.6
    error = np.hypot(0.02 * 0.5**0.6, 0.01 * 0.5)
    assert value == pytest.approx(2.2 - expected)
    assert sigma == pytest.approx(np.hypot(error, 0.01))
    assert terms.notes == ()
    with refused("table: found"):
        tfc.read_table("missing.json")
    for bad in ({"alpha_t": 0.0}, {"C_t": None}, {"C_f": True}, {"hurst": np.nan}, {"sigma": 1}):
        (tmp_path / "bad.json").write_text(
            json.dumps({"tables": [{"observable": "kappa", "p_star": 0.05, "rows": [row | bad]}]})
        )
        with refused("table: found .*bad.json"):
            tfc.read_table("bad.json")
