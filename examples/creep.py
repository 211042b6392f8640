"""A rubber under a load that is applied at once, held, and lowered to a tenth: the contact creeps,
and then recovers."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 256
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
held = np.concatenate([[0], np.geomspace(0.1, 10, 12)])  # seconds
after = 10 + np.concatenate([[0], np.geomspace(0.1, 100, 12)])  # 10 twice: a jump
pressure = np.repeat([0.02, 0.002], [len(held), len(after)])
loads = hpc_gfmd.solve(
    wall, p_star=pressure, time=[*held, *after], relaxation=[(0.6, 1.0), (0.3, 10.0)], fields=()
)

fig, axes = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
for ax, name in zip(axes, ("a_r", "gap_mean")):
    loads.plot(name, ax=ax)
fig.savefig("creep.png", dpi=120)
