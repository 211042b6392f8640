"""A flat strip with free edges: its pressure rises without bound at the edges, where that of a
periodic flat wall is the same everywhere.

boundary = ["free", "periodic"]: one axis has edges, the other repeats. Exact:
p(x) = p_mean/(pi sqrt(s (1 - s))), s = x/L.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 512
smooth = np.zeros((n, n))
rough = (
    0.02
    * hpc_gfmd.make_surface(
        "self-affine", hurst=0.8, L_over_lam_l=4, lam_l_over_lam_s=n // 16, lam_s_over_a=4, seed=1
    ).heights
)
strip = hpc_gfmd.solve(smooth, 0.1, boundary=("free", "periodic"))
punch = hpc_gfmd.solve(rough, 0.01, boundary="free")

fig, (profile, mapped) = plt.subplots(1, 2, figsize=(7.2, 3.2), layout="compressed")
s = (np.arange(n) + 0.5) / n
profile.plot(s, strip.pressure[:, 0] / strip.p, ".", markersize=3, label="computed")
profile.plot(s, 1 / (np.pi * np.sqrt(s * (1 - s))), "0.4", linewidth=0.8, label="exact")
profile.axhline(1.0, color="C1", label="periodic strip")
profile.set(xlabel="$x/L$", ylabel="$p/p_0$", xlim=(0, 1), ylim=(0, 6))
profile.legend()
profile.set_box_aspect(1)
punch.plot("pressure", ax=mapped)
mapped.set_title(f"rough punch, $a_r$ = {100 * punch.a_r:.1f} %", loc="left")
fig.savefig("free_edge.png", dpi=200)
