"""Partial slip of a rough contact under an oscillating tangential load: where it sticks and slips,
and the loop of load and shift (Mindlin)."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 256
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
friction, pressure = 0.5, 0.15
sliding = friction * pressure
up = np.linspace(0.1, 0.8, 8)
down = np.linspace(0.6, -0.8, 8)
share = np.concatenate([up, down, -down, down])  # tangential load over that of sliding
path = hpc_gfmd.slip(friction, pressure, sliding * share)
solutions = hpc_gfmd.solve(wall, path.loads)
result = path.of(solutions)
full = solutions[-1]
softness = full.p / full.observable("stiffness")  # shift of a contact without slip, over friction

fig, (where, curve) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained")
half = 4
sticks = np.abs(result.traction(half)) < friction * full.pressure * (1 - 1e-4)
where.imshow((full.contact + 1.0 * sticks).T, origin="lower", cmap="Greys", vmax=2.5)
where.set(title=f"stick (dark), slip (grey): {share[half]:.2g} of sliding", xticks=[], yticks=[])
scale = friction * full.h_rms
curve.plot(result.shift / scale, share, "o-", label="partial slip")
curve.plot([0, softness / full.h_rms], [0, 1], "--", label="stiffness without slip")
curve.set(xlabel=r"shift $\delta_t/(\mu\, h_\mathrm{rms})$", ylabel=r"tangential load $T/(\mu P)$")
curve.legend()
fig.savefig("partial_slip.png", dpi=120)
