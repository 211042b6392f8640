"""A measured surface against rubber: from the file of a microscope to the contact area, a pressure
map in MPa and um, and the patches.

The scan is a fake: a part of a rough wall, tilted, written as .x3p by SurfaceTopography. Put your
own file in its place.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from SurfaceTopography import Topography

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 512
rough = hpc_gfmd.make_surface(
    "self-affine",
    hurst=0.8,
    L_over_lam_l=2,
    lam_l_over_lam_s=n // 4,
    lam_s_over_a=4,
    seed=3,
    g_rms=0.1,
)
tilt = 0.02 * np.arange(n)[:, None] / (2 * n)
heights = 24_000 * (rough.heights[:n, :n] + tilt)  # nm
Topography(heights, (12_000, 12_000), unit="nm").to_x3p("scan.x3p")

scan = hpc_gfmd.read_surface("scan.x3p", detrend="tilt", boundary="mirror")
print(scan)
solution = hpc_gfmd.solve(scan, "0.2 MPa", "20 MPa")
print(
    f"a_r = {100 * solution.a_r:.2f} % (edge-corrected {100 * solution.a_r_corrected:.2f} %),"
    f" {solution.observable('patches')}"
)
solution.plot().savefig("measured.png")
solution.save(
    "measured.h5", force=True
)  # hpc-gfmd show, plot and export read it, and hpc_gfmd.load

sizes = solution.distribution("patches")
fig, ax = plt.subplots(figsize=(3.6, 3), layout="constrained")
ax.stairs(sizes["density"] / 1e12, sizes["edges"] * 1e12, baseline=None)  # 1/um^2, um^2
ax.set(xscale="log", yscale="log", xlabel="patch size $A$ (µm$^2$)", ylabel="$P(A)$ (µm$^{-2}$)")
fig.savefig("measured_patches.png", dpi=200)
