"""Thirty realisations of one surface: mean and scatter of contact area and gap over the load."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 128
keys = {"hurst": 0.8, "L_over_lam_l": 2, "lam_l_over_lam_s": n // 8, "lam_s_over_a": 4}
walls = (hpc_gfmd.make_surface("self-affine", seed=seed, **keys) for seed in range(30))
loads = np.geomspace(0.003, 0.3, 7)
ensemble = hpc_gfmd.Ensemble(hpc_gfmd.solve_many(walls, p_star=loads, fields=()))
print(ensemble)

fig, (area, gap) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
ensemble.plot("a_r", ax=area)
ensemble.plot("gap_mean", ax=gap)
area.legend()
fig.savefig("ensemble.png", dpi=120)
