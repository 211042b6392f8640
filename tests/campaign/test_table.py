"""How the campaign judges rows."""

import pytest
from campaign.table import above_estimate, failures, less_accurate, line, report, worst_of_each

GOOD = {
    "family": "wave",
    "seed": 1,
    "index": 2,
    "solver": "bpx",
    "precision": "auto",
    "accuracy": 1e-2,
    "low_memory": False,
    "load": 0,
    "n": [8, 8],
    "p_star": 0.1,
    "contact": 5,
    "kkt": 1e-14,
    "status": "converged",
    "true": [0.0, 1e-3, 1e-4],
    "claimed": [0.0, 2e-3, 2e-3],
    "iterations": 3,
    "fft_pairs": 5.0,
}
INACCURATE = GOOD | {"index": 3, "true": [0.0, 2e-2, 1e-4]}
WRONG_ESTIMATE = GOOD | {"index": 4, "true": [0.0, 1e-3, 3e-3]}
NOT_A_NUMBER = GOOD | {"index": 5, "true": [0.0, float("nan"), float("inf")]}


def test_what_counts_as_a_failure():
    assert not less_accurate(GOOD)
    assert not above_estimate(GOOD)
    assert less_accurate(INACCURATE) == ["gap"]
    assert not above_estimate(INACCURATE)
    assert above_estimate(WRONG_ESTIMATE) == ["pressure"]
    assert less_accurate(NOT_A_NUMBER) == ["gap", "pressure"]


@pytest.mark.parametrize("change", [{"status": "stagnated"}, {"kkt": 1e-3}, {"kkt": float("nan")}])
def test_what_is_not_judged(change):
    assert not less_accurate(INACCURATE | change)
    assert not above_estimate(WRONG_ESTIMATE | change)


def test_the_report_counts_and_reproduces():
    rows = [
        GOOD,
        INACCURATE,
        INACCURATE | {"load": 1},
        WRONG_ESTIMATE,
        GOOD | {"status": "stagnated"},
    ]
    text = report(rows)
    assert "| wave | 5 | 4 | 2 (0 / 2 / 0) | 1 (0 / 0 / 1) | 1 stagnated | 5.0 |" in text
    assert (
        "--family wave --seed 1 --index 3 --solvers bpx --precision auto --accuracy 0.01"
        in line(failures(rows)[0])
    )
    assert len(worst_of_each(failures(rows))) == 2
