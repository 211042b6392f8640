"""More ranks than cores: the same contact as on one rank, and the planned messages."""

from pathlib import Path

import mpi_harness
import pytest

SCRIPT = Path(__file__).with_name("many_ranks.py")
# (number of ranks, ranks on each node)
RANKS = (2, 2), (4, 4), (8, 8), (8, 1), (16, 16), (16, 4)
ROUNDING = 1e-9


def numbers_of(ranks, per_node, folder):
    """Return the numbers of many_ranks.py for 2048 x 2048 points."""
    return mpi_harness.json_of(ranks, [SCRIPT, 512, per_node, folder], timeout=3000)


@pytest.mark.slow
@pytest.mark.alone
def test_2048(tmp_path):
    if mpi_harness.missing():
        pytest.skip(f"{mpi_harness.missing()} is missing")
    alone = numbers_of(1, 1, tmp_path)
    assert alone["status"] == "converged"
    for ranks, per_node in RANKS:
        many = numbers_of(ranks, per_node, tmp_path)
        for name in ("n", "status", "contact"):
            assert many[name] == alone[name]
        assert many["gap_mean"] == pytest.approx(alone["gap_mean"], rel=ROUNDING)
        assert max(many["pressure"], many["gap"]) <= ROUNDING
        assert len(many["messages"]) == ranks
        assert all(counted == planned for counted, planned in many["messages"])
        assert 0 < many["grids"][0] <= ranks
    assert many["n"] == 2048
    assert many["levels"] == 3  # rank 0 alone has those up to 128 x 128
    assert many["grids"] == [16, 16, 8, 2, 1, 1]  # down to 32 x 32
