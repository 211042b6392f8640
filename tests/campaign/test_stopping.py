"""Estimates are not only safe: the solver stops hardly later than one who knew the true errors
would."""

import os
import warnings

import numpy as np
import pytest
from campaign import families
from campaign.kept import truths

import hpc_gfmd
from hpc_gfmd.util.errors import NotConverged

PROBLEMS = float(os.environ.get("HPC_GFMD_PROBLEMS", 1))
SEED = int(os.environ.get("HPC_GFMD_SEED", 2311))
WALLS = 40
LATE = 3.0  # iterations, in the mean


def iterations_too_many(wall, precision, accuracy):
    """Iterations of a solve beyond the first of which all true errors were below the accuracy; None
    if it did not converge."""
    contact, (truth,), _ = truths(wall.heights, wall.physical_sizes, wall.loads)

    def solve(most):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotConverged)
            return hpc_gfmd.solve(
                wall.heights,
                wall.loads[0] * wall.E_star * contact.g_rms,
                wall.E_star,
                wall.physical_sizes,
                accuracy,
                precision=precision,
                max_iterations=most,
            )

    done = solve(1000)
    if done.status != "converged":
        return None
    for most in range(1, done.iterations):
        s = solve(most)
        pressure = np.asarray(s.pressure, np.float64) / wall.E_star / contact.g_rms
        if (
            max(
                truth.errors(
                    round(s.a_r * wall.heights.size), s.gap_mean / contact.height_unit, pressure
                )
            )
            < accuracy
        ):
            return done.iterations - most
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
    known = [x for found in late.values() for x in found if x is not None]
    print(
        precision,
        *(f"{accuracy:g}: {found}" for accuracy, found in late.items()),
        f"mean {np.mean(known):.2f}",
        sep="\n",
    )
    assert len(known) > 0.9 * len(walls) * len(accuracies)
    assert np.mean(known) <= LATE
