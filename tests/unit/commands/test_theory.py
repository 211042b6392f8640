"""`hpc-gfmd persson` and `hpc-gfmd tfc`: output, fits and refused arguments."""

import numpy as np
import pytest
from scene_tables import rows

from hpc_gfmd.theory import persson

PERSSON = "persson --hurst 0.8 --eps-f 0.0009765625 --p-star 0.007"
TFC = "tfc --hurst 0.8 --p-star 0.007 --eps-t 0.5 --eps-f 1/1024 --eps-c 0.5"


def test_persson(cli):
    out = cli.data(PERSSON)
    assert out["a_r"] == pytest.approx(0.0111700190)
    assert out["gap_over_h_rms"] == pytest.approx(persson.mean_gap(0.007, 0.8, 2**-10))
    assert out["gap_over_g_rms_lam_s"] == pytest.approx(31.5614069)
    assert out["gamma"] == 0.42
    assert cli.data(f"{PERSSON} --printed")["gap_over_h_rms"] < out["gap_over_h_rms"]
    assert len(cli.data(f"{PERSSON} 0.1 40")["points"]) == 3
    text = cli.prints("persson --hurst 0 --eps-f 1/1024 --p-star-range 0.001 1 7")
    assert len(text.splitlines()) == 9


def test_tfc(cli):
    out = cli.data(f"{TFC} --observable kappa --value 2.2")
    assert out["extrapolated"] == pytest.approx(2.0160, abs=5e-5)
    assert out["sigma"] is None
    assert "extrapolated: 2.0160 +- 0.0200" in cli.prints(f"{TFC} --value 2.2 --sigma 0.02")


def test_tfc_fits(cli, tmp_path):
    """A fit of a table of runs recovers a planted law."""
    t, f, c = np.random.default_rng(2).choice([0.5, 0.25, 0.125, 0.0625], (3, 36))
    value = 1.95 + 0.04 * t + 3 * f**0.7 + 0.3 * c**0.9
    lines = ["eps_t,eps_f,eps_c,value", *map("{},{},{},{}".format, t, f, c, value)]
    (tmp_path / "runs.csv").write_text("\n".join(lines))
    out = cli.data("tfc --fit runs.csv --free fc")
    assert (out["limit"], out["alpha_f"]) == pytest.approx((1.95, 0.7), rel=1e-5)
    assert "alpha_t = 1 (fixed)" in cli.prints("tfc --fit runs.csv")


@pytest.mark.parametrize(
    ("command", "options", "words"),
    rows("""
persson | --hurst 2 | hurst: found
persson | --eps-f nan | eps_f: found
persson | --p-star 0 | p_star: found
persson | --gamma 9 | gamma: found
tfc |  | --value
tfc | --value nan | value: found nan
tfc | --value 2 --hurst 0.1 | hurst
tfc | --value 2 --terms t | tfc: found --terms, allowed: with --fit
fit |  | runs: found
fit | --free x | free: found
fit | --eps-t 1 --table ours | tfc: found --eps-t, --table, allowed: without --fit
tfc | --value 2 --sigma -1 | sigma
"""),
)
def test_wrong_options_are_refused(command, options, words, cli):
    commands = {"persson": PERSSON, "tfc": TFC, "fit": "tfc --fit /nowhere.csv"}
    assert words in cli.refused(f"{commands[command]} {options}")
