"""Adhesive walls for tests, in units of the shortest wavelength, with rms slope 1 and E* = 1."""

import numpy as np
from contacts import rough_wall

import hpc_gfmd

LOAD = 0.05  # p*


def wall(points=8, waves=8, seed=1):
    """A self-affine wall; points: lam_s/a; waves: lam_l/lam_s."""
    return rough_wall(
        (2, waves, points), seed=seed, g_rms=1.0, physical_sizes=(2.0 * waves, 2.0 * waves)
    )


def attraction(kappa, reach, law="exponential"):
    """The table material.adhesion; kappa: work/(range^2 E* q_s/2)."""
    return {"work": kappa * np.pi * reach**2, "range": reach, "law": law}


def retracted(surface, adhesion, load=LOAD, **options):
    """The contact at a load that is approached from much larger loads."""
    loads = [8.0, 1.0, 0.3, load]
    return hpc_gfmd.solve(surface, loads, adhesion=adhesion, branch="retraction", **options)[-1]
