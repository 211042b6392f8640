"""`hpc-gfmd persson` and `hpc-gfmd tfc`: output and refused arguments."""

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
    assert "-> 2.0160 +- 0.02" in cli.prints(f"{TFC} --value 2.2 --sigma 0.02")


WRONG = rows("""
persson | --hurst 2 | hurst: found
persson | --eps-f nan | eps_f: found
persson | --p-star 0 | p_star: found
persson | --gamma 9 | gamma: found
tfc |  | --value
tfc | --value nan | value: found nan
tfc | --value 2 --hurst 0.1 | hurst
tfc | --value 2 --sigma -1 | sigma
""")


def test_wrong_options_are_refused(cli):
    commands = {"persson": PERSSON, "tfc": TFC}
    for command, options, words in WRONG:
        assert words in cli.refused(f"{commands[command]} {options}")
