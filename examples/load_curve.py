"""A self-affine wall under rising loads: contact area and mean gap over the load, Persson's theory,
and the shipped reference data.

A list of loads is a sweep: each starts from the previous one where that is near, and all come back
as one sequence.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd
from hpc_gfmd.theory import persson

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 2048
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
p_star = np.geomspace(0.005, 0.5, 9)  # p/(E* g_rms)
fine = np.geomspace(0.004, 0.6, 99)
solutions = hpc_gfmd.solve(wall, p_star=p_star, fields=(), progress=True)
print(solutions)

fig, (area, gap) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
area.loglog(p_star, solutions.values("a_r"), "o", label="as counted")
area.loglog(p_star, solutions.values("a_r_corrected"), "s", markersize=4, label="edge-corrected")
area.loglog(fine, persson.contact_area(fine), "0.4", zorder=1, label="Persson")
gap.loglog(p_star, solutions.values("gap_over_h_rms"), "o", label="computed")
gap.loglog(fine, persson.mean_gap(fine, hurst=0.8, eps_f=8 / n), "0.4", zorder=1, label="Persson")
known = np.array([0.01, 0.05, 0.2])  # with uncertainties, from many large walls
values, sigmas = np.transpose(
    [hpc_gfmd.reference.contact_area(p, hurst=0.8, eps_f=1 / 256) for p in known]
)
area.errorbar(known, values, sigmas, fmt="k_", markersize=12, zorder=3, label="reference")
area.set(xlabel="$p^*$", ylabel="contact area $a_r$")
gap.set(xlabel="$p^*$", ylabel=r"mean gap $\langle g \rangle/h_\mathrm{rms}$")
area.legend()
gap.legend()
fig.savefig("load_curve.png", dpi=200)
