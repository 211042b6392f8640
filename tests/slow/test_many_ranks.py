"""More ranks than there are cores: the same contact as on one, and as many messages as planned."""

from pathlib import Path

import mpi_harness
import pytest

SCRIPT = Path(__file__).with_name("many_ranks.py")
# numbers of ranks, and how many of them share a node
RANKS = (2, 2), (4, 4), (8, 8), (8, 1), (16, 16), (16, 4)
ROUNDING = 1e-9


def solved(ranks, per_node, folder):
    """What many_ranks.py says of 2048 x 2048 points."""
    return mpi_harness.json_of(ranks, [SCRIPT, 512, per_node, folder], timeout=3000)


@pytest.mark.slow
def test_2048(tmp_path):
    if mpi_harness.missing():
        pytest.skip(f"{mpi_harness.missing()} is missing")
    alone = solved(1, 1, tmp_path)
    assert alone["status"] == "converged"
    for ranks, per_node in RANKS:
        found = solved(ranks, per_node, tmp_path)
        assert {name: found[name] for name in ("n", "status", "contact")} == {
            name: alone[name] for name in ("n", "status", "contact")
        }
        assert found["gap_mean"] == pytest.approx(alone["gap_mean"], rel=ROUNDING)
        assert max(found["pressure"], found["gap"]) <= ROUNDING
        assert len(found["messages"]) == ranks
        assert all(counted == planned for counted, planned in found["messages"])
        assert 0 < found["grids"][0] <= ranks
    assert found["n"] == 2048
    assert found["levels"] == 3  # rank 0 alone has those up to 128 x 128
    assert found["grids"] == [16, 16, 8, 2, 1, 1]  # down to 32 x 32
