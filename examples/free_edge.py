"""A flat strip that ends: its pressure rises without bound at the edges, where that of a periodic
flat wall is the same everywhere.

boundary = ["free", "periodic"]: one axis ends, the other does not. Exact: p(x) = p_mean/(pi sqrt(s
(1 - s))), s = x/L.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

n = int(sys.argv[1]) if sys.argv[1:] else 256
smooth = np.zeros((n, n))
rough = (
    0.02
    * hpc_gfmd.make_surface(
        "self-affine", hurst=0.8, L_over_lam_l=4, lam_l_over_lam_s=n // 16, lam_s_over_a=4, seed=1
    ).heights
)
strip = hpc_gfmd.solve(smooth, 0.1, boundary=("free", "periodic"))
punch = hpc_gfmd.solve(rough, 0.01, boundary="free")

fig, (profile, mapped) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
s = (np.arange(n) + 0.5) / n
profile.plot(s, strip.pressure[:, 0] / strip.p, ".", markersize=3, label="computed")
profile.plot(s, 1 / (np.pi * np.sqrt(s * (1 - s))), "0.4", linewidth=0.8, label="exact")
profile.axhline(1.0, color="C1", label="periodic")
profile.set(xlabel="x / L", ylabel="p / p_mean", ylim=(0, 6))
profile.legend()
image = mapped.imshow(
    np.where(punch.contact, punch.pressure, np.nan).T / punch.p,
    origin="lower",
    extent=(0, 1, 0, 1),
    cmap="magma_r",
)
fig.colorbar(image, label="p / p_mean")
mapped.set(xlabel="x / L", ylabel="y / L", title=f"rough punch, a_r = {100 * punch.a_r:.1f} %")
fig.savefig("free_edge.png", dpi=200)
