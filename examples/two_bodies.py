"""Two rough bodies are one: the sum of their heights against a smooth body."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 256
bodies = {"body 1": {"hurst": 0.8, "g_rms": 0.1}, "body 2": {"hurst": 0.3, "g_rms": 0.07}}
heights = {
    name: hpc_gfmd.make_surface(
        "self-affine", L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=k, **keys
    ).heights
    for k, (name, keys) in enumerate(bodies.items())
}
heights["both"] = heights["body 1"] + heights["body 2"]

fig, (plain, scaled) = plt.subplots(1, 2, figsize=(7.2, 3), sharey=True, layout="constrained")
for name, z in heights.items():
    loads = hpc_gfmd.solve(z, np.geomspace(5e-4, 2e-2, 6), boundary="periodic", fields=())
    area = 100 * loads.values("a_r")
    plain.loglog(loads.values("p"), area, "o-", label=f"{name}: {loads[0].g_rms:.3f}")
    scaled.loglog(loads.values("p_star"), area, "o-")
plain.set(xlabel="pressure $p/E^*$", ylabel="contact area $a_r$ (%)")
plain.legend(title=r"rms slope $g_\mathrm{rms}$")
scaled.set(xlabel=r"pressure $p/(E^* g_\mathrm{rms})$")
fig.savefig("two_bodies.png", dpi=120)
