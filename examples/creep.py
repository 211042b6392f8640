"""Creep under a constant load: a viscoelastic contact at the time t is the elastic one under the
load times J(t)/J(0) (Lee and Radok)."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 256
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
time = np.geomspace(0.01, 10, 10)  # in units of the retardation time
softer = 1 + 9 * (1 - np.exp(-time))  # J(t)/J(0) of the standard linear solid
loads = hpc_gfmd.solve(wall, p_star=0.02 * softer, fields=())

fig, (area, gap) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
area.semilogx(time, 100 * loads.values("a_r"), "o-")
area.set(xlabel=r"time $t/\tau$", ylabel="contact area $a_r$ (%)")
gap.semilogx(time, loads.values("gap_over_h_rms"), "o-")
gap.set(xlabel=r"time $t/\tau$", ylabel=r"mean gap over $h_\mathrm{rms}$")
fig.savefig("creep.png", dpi=120)
