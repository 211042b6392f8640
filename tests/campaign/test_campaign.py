"""Converged means converged: a tenth of the families in the quick tests, all of them, and all solvers, marked slow."""

import os

import pytest

from campaign.run import ACCURACIES, PRECISIONS, names, ways
from campaign.solving import rows_of
from campaign.table import failures, line, report

PROBLEMS = float(os.environ.get("HPC_GFMD_PROBLEMS", 1))  # 1: as many as here, 0.1: a tenth
SEED = int(os.environ.get("HPC_GFMD_SEED", 2311))
WALLS = 8  # of each family
BPX = ways(["bpx"], PRECISIONS, ACCURACIES, "yes")
OTHERS = ways(["gfmd", "fire", "ccg"], ["double", "single"], [1e-2, 1e-4], "no")
QUICK = ways(["bpx"], ["single", "double"], [1e-2, 1e-3, 1e-6], "yes")


def check(rows):
    """No row claims what is not true, and none has failed otherwise."""
    bad = [line(row) for row in failures(rows)]
    broken = [row for row in rows if "error" in row and row["status"] != "refused"]
    bad += [f"{row['family']} {row['index']}: {row['status']} {row['error']}" for row in broken]
    assert not bad, "\n".join(bad[:20])
    doubtful = [row for row in rows if "kkt" in row and not row["kkt"] < 1e-10]
    assert not doubtful


@pytest.mark.slow
@pytest.mark.parametrize("name", names(["all"]))
def test_the_default_solver_on_every_family(name):
    rows = [row for index in range(max(round(WALLS * PROBLEMS), 1)) for row in rows_of(name, SEED, index, BPX)]
    print(report(rows))
    check(rows)


@pytest.mark.slow
@pytest.mark.parametrize("name", names(["single"], without=["rough_large", "smooth_near_full_large"]))
def test_the_other_solvers_on_every_family(name):
    rows = [row for index in range(max(round(2 * PROBLEMS), 1)) for row in rows_of(name, SEED, index, OTHERS)]
    print(report(rows))
    check(rows)
