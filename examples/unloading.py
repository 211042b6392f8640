"""A metal that is loaded and unloaded: dents stay, so that the gap returns on another curve."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 256
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
rising = np.geomspace(0.002, 0.1, 9)  # in units of E* g_rms, as the hardness
falling = rising[-2::-1]
metal = {"hardness": 0.5, "fields": ["pressure", "gap", "dent"]}
loads = hpc_gfmd.solve(wall, [*rising, *falling], history=True, **metal)
without = hpc_gfmd.solve(wall, rising, hardness=0.5, fields=())

gap = loads.values("gap_over_h_rms")
fig, (curve, dents) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained")
curve.semilogx(rising, gap[:9], "o", label="loading")
curve.semilogx(falling, gap[9:], "x-", label="unloading")
curve.semilogx(rising, without.values("gap_over_h_rms"), "--", label="without memory")
curve.set(xlabel=r"pressure $p^*$", ylabel=r"mean gap over $h_\mathrm{rms}$")
curve.legend()
image = dents.imshow(loads[-1].dent.T / wall.h_rms, origin="lower", cmap="magma_r")
fig.colorbar(image, label=r"depth of dents over $h_\mathrm{rms}$")
dents.set(xticks=[], yticks=[], title=f"{loads.values('a_plastic')[-1]:.1%} is dented")
fig.savefig("unloading.png", dpi=120)
