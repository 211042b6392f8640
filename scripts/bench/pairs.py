"""FFT pairs of a load, means over surfaces that differ in their seed: the cost that depends on no
machine."""

from itertools import product

import numpy as np

import hpc_gfmd

from .contacts import Case
from .report import Report


def run(args):
    """Report every size and accuracy; args: of command.py. Raises SceneError."""
    if len(args.surfaces) != len(args.n):
        raise hpc_gfmd.SceneError(
            f"--surfaces: found {len(args.surfaces)} numbers, allowed: one for each of --n"
        )
    report = Report("pairs", args.out)
    for (n, surfaces), accuracy in product(zip(args.n, args.surfaces), args.accuracy):
        found = [
            Case(n, p_star, args.hurst, seed=seed).press(precision="single", accuracy=accuracy)[0]
            for seed in range(1, surfaces + 1)
            for p_star in args.p_star
        ]
        report.add(
            n=n,
            accuracy=accuracy,
            surfaces=surfaces,
            loads=len(found),
            converged=sum(row["status"] == "converged" for row in found),
            fft_pairs=float(np.mean([row["fft_pairs"] for row in found])),
            largest=max(row["fft_pairs"] for row in found),
            iterations=float(np.mean([row["iterations"] for row in found])),
        )
    report.finish()
