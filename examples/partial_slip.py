"""Partial slip from a sweep of normal loads: what touches under a smaller load sticks, the rest of
the contact slips (Ciavarella, Jaeger)."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 256
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
share = np.linspace(0, 0.95, 9)  # tangential load over friction times normal load
loads = hpc_gfmd.solve(wall, p_star=0.15 * (1 - share))
full, half = loads[0], loads[4]
shift = (loads.values("gap_mean") - full.gap_mean) / full.h_rms
softness = full.p / (full.observable("stiffness") * full.h_rms)  # shift of a contact without slip

fig, (where, curve) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained")
where.imshow((full.contact + 1.0 * half.contact).T, origin="lower", cmap="Greys", vmax=2.5)
where.set(title=f"stick (dark), slip (grey): {share[4]:.2f} of sliding", xticks=[], yticks=[])
curve.plot(shift, share, "o-", label="partial slip")
curve.plot([0, softness], [0, 1], "--", label="stiffness without slip")
curve.set(
    xlabel=r"shift $\frac{2 (1 - \nu)}{(2 - \nu) \mu}\, \delta_t/h_\mathrm{rms}$",
    ylabel=r"tangential load $T/(\mu P)$",
)
curve.legend()
fig.savefig("partial_slip.png", dpi=120)
