"""Contact conductance of heat and of electric current against the load, beside the formula that
engineers use (Mikic 1974, elastic)."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 512
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=4, lam_l_over_lam_s=n // 16, lam_s_over_a=4, seed=1
)
solutions = hpc_gfmd.solve(
    wall, p_star=np.geomspace(0.002, 0.3, 8), fields=(), observables=["conductance"]
)

p = solutions.values("p")  # in units of E*
h_rms, g_rms = solutions[0].h_rms, solutions[0].g_rms
slope = g_rms / np.sqrt(np.pi)  # mean absolute slope of a profile
mikic = 1.55 * slope / h_rms * (np.sqrt(2) * p / slope) ** 0.94

fig, ax = plt.subplots(figsize=(4.5, 3.4), layout="constrained")
ax.loglog(p / g_rms, solutions.values("conductance") * h_rms, "o-", label="this contact")
ax.loglog(p / g_rms, mikic * h_rms, "--", label="Mikic (1974), elastic")
ax.set(xlabel=r"pressure $p/(E^* g_\mathrm{rms})$", ylabel=r"conductance $h\, h_\mathrm{rms}/k$")
ax.legend()
fig.savefig("conductance.png", dpi=150)
