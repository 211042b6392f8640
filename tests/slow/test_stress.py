"""Solvers on surfaces and numbers of every kind: nothing raises or claims what is not
true."""

import os
import warnings
from collections import Counter

import pytest
from slow.cases import odd_problems

import hpc_gfmd
from hpc_gfmd.solvers import solver_names

PROBLEMS = float(os.environ.get("HPC_GFMD_PROBLEMS", 1))
SEED = int(os.environ.get("HPC_GFMD_SEED", 7))
OTHERS = sorted(set(solver_names()) - {"bpx"})


def run(problem, **settings):
    """(status, what is wrong or None) of one problem."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", hpc_gfmd.util.errors.NotConverged)  # the status tells
        try:
            solution = hpc_gfmd.solve(
                problem.heights,
                problem.pressure,
                problem.E_star,
                problem.sizes,
                **problem.settings | settings,
            )
        except Exception as error:  # whatever it is, it is what this test looks for
            return "raised", f"{type(error).__name__}: {error}"
    return solution.status, problem.falsehood(solution)


def report(name, problems, results):
    counts = Counter(status for status, _ in results)
    print(f"{name}: {len(results)} problems, {dict(counts)}")
    for problem, (status, wrong) in zip(problems, results, strict=True):
        if status != "converged" or wrong:
            print(f"  {status} {wrong or ''} {problem}")


@pytest.mark.slow
def test_the_default_solver_converges_on_everything():
    problems = odd_problems(max(int(1000 * PROBLEMS), 20), SEED)
    results = [run(problem) for problem in problems]
    report("bpx", problems, results)
    # Where single precision was insisted on it may be too little, which the status tells.
    assert not [
        p
        for p, (status, wrong) in zip(problems, results, strict=True)
        if wrong
        or (
            status != "converged"
            and not (status == "stagnated" and p.settings["precision"] == "single")
        )
    ]


@pytest.mark.slow
@pytest.mark.parametrize("name", OTHERS)
def test_the_other_solvers_fail_honestly(name):
    problems = odd_problems(max(int(60 * PROBLEMS), 6), SEED + 1, n=(16, 64))
    results = [run(problem, name=name, max_iterations=2000) for problem in problems]
    report(name, problems, results)
    assert not [
        p
        for p, (status, wrong) in zip(problems, results, strict=True)
        if wrong or status == "raised"
    ]
