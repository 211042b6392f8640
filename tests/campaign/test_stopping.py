"""Estimates are not too cautious: the solver stops soon after the true errors meet the accuracy."""

import os
import warnings

import numpy as np
import pytest
from campaign import families
from campaign.truth import truths

import hpc_gfmd
from hpc_gfmd.util.errors import NotConverged

PROBLEMS = float(os.environ.get("HPC_GFMD_PROBLEMS", 1))
SEED = int(os.environ.get("HPC_GFMD_SEED", 2311))
WALLS = 40
LATE = 3.0  # mean number of superfluous iterations


def iterations_too_many(wall, precision, accuracy):
    """Return the iterations after all true errors met the accuracy; None without convergence."""
    contact, (truth,), _ = truths(wall.heights, wall.physical_sizes, wall.loads)

    def solve(max_iterations):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotConverged)
            return hpc_gfmd.solve(
                wall.heights,
                wall.loads[0] * wall.E_star * contact.g_rms,
                wall.E_star,
                wall.physical_sizes,
                accuracy,
                precision=precision,
                max_iterations=max_iterations,
            )

    converged = solve(1000)
    if converged.status != "converged":
        return None
    for iterations in range(1, converged.iterations):
        solution = solve(iterations)
        if max(contact.errors_of(solution, truth, wall.E_star)) < accuracy:
            return converged.iterations - iterations
    return 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("precision", "accuracies"), [("single", (1e-2, 1e-3)), ("double", (1e-2, 1e-3, 1e-4, 1e-6))]
)
def test_the_solver_stops_in_time(precision, accuracies):
    walls = [
        families.make("self_affine", SEED, index)
        for index in range(max(round(WALLS * PROBLEMS), 4))
    ]
    late = {
        accuracy: [iterations_too_many(wall, precision, accuracy) for wall in walls]
        for accuracy in accuracies
    }
    converged = [count for counts in late.values() for count in counts if count is not None]
    print(
        precision,
        *(f"{accuracy:g}: {counts}" for accuracy, counts in late.items()),
        f"mean {np.mean(converged):.2f}",
        sep="\n",
    )
    assert len(converged) > 0.9 * len(walls) * len(accuracies)
    assert np.mean(converged) <= LATE
