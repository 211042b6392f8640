"""Rubber pressed on a rough wall: gap and pressure over a square millimetre, and a part of it.

From afar a patch of contact looks whole. It splits into smaller ones, down to the shortest wave.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 2048
wall = hpc_gfmd.make_surface(
    "self-affine",
    hurst=0.8,
    L_over_lam_l=2,
    lam_l_over_lam_s=n // 8,
    lam_s_over_a=4,
    seed=1,
    g_rms=0.2,
    physical_sizes=("1 mm", "1 mm"),
)
solution = hpc_gfmd.solve(wall, "50 kPa", "5 MPa")
print(solution)
blue = ListedColormap(plt.get_cmap("Blues")(np.linspace(0, 0.65, 256)))
warm = ListedColormap(plt.get_cmap("YlOrRd")(np.linspace(0.25, 1, 256)))
gap, pressure = solution.gap * 1e6, np.ma.masked_equal(solution.pressure, 0) / 1e6  # um, MPa

fig, axes = plt.subplots(1, 2, figsize=(7.2, 4.2), layout="constrained")
for ax, (x0, x1, y0, y1) in zip(axes, ((0, 1, 0, 1), (0.57, 0.73, 0.69, 0.85))):  # mm
    part = np.s_[round(x0 * n) : round(x1 * n), round(y0 * n) : round(y1 * n)]
    how = {"origin": "lower", "extent": (x0, x1, y0, y1)}
    below = ax.imshow(gap[part].T, cmap=blue, vmin=0, vmax=gap.max(), **how)
    above = ax.imshow(pressure[part].T, cmap=warm, vmin=0, vmax=1.4, **how)
    ax.set(xlabel="$x$ (mm)", ylabel="$y$ (mm)")
axes[1].yaxis.set(label_position="right", ticks_position="right")
axes[0].indicate_inset_zoom(axes[1], edgecolor="black")
for ax, image, label in zip(axes, (below, above), ("gap $g$ (µm)", "pressure $p$ (MPa)")):
    fig.colorbar(image, ax=ax, location="bottom", label=label, aspect=40)
fig.savefig("zoom.png", dpi=250)
