"""A coating on an elastic half-space: long waves meet the substrate, short ones the coating."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 256
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
thickness = np.geomspace(0.002, 0.5, 7)  # in units of L
half_space = hpc_gfmd.solve(wall, p_star=0.05, fields=())

fig, ax = plt.subplots(figsize=(4.5, 3.4), layout="constrained")
for base_E in (10, 3, 1, 0.3):  # over E* of the coating
    lies_on = {"nu": 0.3, "base": "elastic", "base_E": base_E, "base_nu": 0.3}
    solved = [
        hpc_gfmd.solve(wall, p_star=0.05, thickness=t, fields=(), **lies_on) for t in thickness
    ]
    ax.loglog(thickness, [100 * one.a_r for one in solved], "o-", label=f"{base_E:g}")
ax.axhline(100 * half_space.a_r, color="0.4", linewidth=0.8, label="all coating")
ax.set(xlabel="thickness $t/L$", ylabel="contact area $a_r$ (%)")
ax.legend(title="$E$ of the substrate")
fig.savefig("coating.png", dpi=150)
