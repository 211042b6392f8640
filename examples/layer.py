"""A rough wall on an elastic layer of finite thickness on a rigid base: the thinner it is, the
stiffer, and the smaller the contact."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 512
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
thickness = np.geomspace(0.005, 1, 6)  # in units of L
bases = {"bonded": "o-", "frictionless": "s-"}
half_space = hpc_gfmd.solve(wall, p_star=0.05)

fig, (area, gap) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
for base, style in bases.items():
    solved = [hpc_gfmd.solve(wall, p_star=0.05, thickness=t, nu=0.45, base=base) for t in thickness]
    area.semilogx(thickness, [100 * one.a_r for one in solved], style, label=base)
    gap.semilogx(thickness, [one.gap_mean / one.h_rms for one in solved], style, label=base)
area.axhline(100 * half_space.a_r, color="0.4", linewidth=0.8, label="half-space")
gap.axhline(half_space.gap_mean / half_space.h_rms, color="0.4", linewidth=0.8)
area.set(xlabel="thickness $t/L$", ylabel="contact area $a_r$ (%)")
gap.set(xlabel="thickness $t/L$", ylabel=r"mean gap $\langle g \rangle/h_\mathrm{rms}$")
area.legend(title="base")
fig.savefig("layer.png", dpi=200)
