"""FFT pairs of a load, averaged over surfaces with different seeds: a cost that does not depend on
the machine."""

from itertools import product

import numpy as np

import hpc_gfmd

from .contacts import RoughContact
from .report import Report


def run(args):
    """Report every size and accuracy. Raises SceneError unless --surfaces has a number for each
    size."""
    if len(args.surfaces) != len(args.n):
        raise hpc_gfmd.SceneError(
            f"--surfaces: found {len(args.surfaces)} numbers, allowed: one for each of --n"
        )
    report = Report("pairs", args.out)
    for (n, surfaces), accuracy in product(zip(args.n, args.surfaces), args.accuracy):
        contacts = [
            RoughContact(n, p_star, args.hurst, seed=seed)
            for seed in range(1, surfaces + 1)
            for p_star in args.p_star
        ]
        rows = [contact.press(precision="single", accuracy=accuracy)[0] for contact in contacts]
        report.add(
            n=n,
            accuracy=accuracy,
            surfaces=surfaces,
            loads=len(rows),
            converged=sum(row["status"] == "converged" for row in rows),
            fft_pairs=float(np.mean([row["fft_pairs"] for row in rows])),
            largest=max(row["fft_pairs"] for row in rows),
            iterations=float(np.mean([row["iterations"] for row in rows])),
        )
    report.finish()
