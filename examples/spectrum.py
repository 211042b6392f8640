"""Walls of one spectrum: isotropic, with a lay, with deep valleys, and finer than a scan shows.

The spectrum is constant down to 20 µm and falls with H = 0.8. A piece of the first wall is scanned
with points 0.4 µm apart; its spectrum, which goes on with the exponent of its own end, gives
another wall.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import NullLocator

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 1024
spacing = 100 / n  # um
laws = {
    "wavelengths": ["100 um", "20 um", f"{4 * spacing} um"],
    "hurst": [-1.0, 0.8],
    "g_rms": 0.1,
    "n": (n, n),
    "physical_sizes": ("100 um", "100 um"),
    "seed": 1,
}
walls = {
    "isotropic": hpc_gfmd.make_surface("spectrum", **laws),
    "Peklenik number 5, 30°": hpc_gfmd.make_surface(
        "spectrum", **laws | {"peklenik": 5.0, "angle": 30.0, "shortest": f"{10 * spacing} um"}
    ),
    "skewness −2, kurtosis 9": hpc_gfmd.make_surface(
        "spectrum", **laws, skewness=-2.0, kurtosis=9.0
    ),
}

part = walls["isotropic"].heights[: n // 2 : 4, : n // 2 : 4]
scan = hpc_gfmd.prepare_surface(part, physical_sizes=("50 um", "50 um"), unit="m", boundary="free")
shortest = 16e-6 * spacing  # four points of the scan, in m: finer waves of it are aliased
measured = hpc_gfmd.spectrum_of(scan).between(0, 2 * np.pi / shortest)
extended = measured.extended(4e-6 * spacing)
extended.write("spectrum.csv")
again = hpc_gfmd.make_surface(
    "spectrum", path="spectrum.csv", n=(n, n), physical_sizes=("100 um", "100 um"), seed=2
)
for name, wall in walls.items():
    print(name, wall, sep=": ")
print(extended, again, sep="\n")

fig, axes = plt.subplots(2, 2, figsize=(7.2, 6.4), layout="constrained")
for ax, (name, wall) in zip(axes.flat, walls.items()):
    z = wall.heights - wall.heights.mean()
    how = {"origin": "lower", "extent": (0, 100, 0, 100), "cmap": "Greys_r"}
    image = ax.imshow(z.T * 1e6, vmin=-4e6 * wall.h_rms, vmax=4e6 * wall.h_rms, **how)
    ax.set(title=name, xlabel="$x$ (µm)", ylabel="$y$ (µm)")
    fig.colorbar(image, ax=ax, label="$z$ (µm)")
ax = axes[1, 1]
lines = {
    "isotropic wall": (hpc_gfmd.spectrum_of(walls["isotropic"]), {}),
    "scan of it, extended": (extended, {"linestyle": "--"}),
    "scan of it": (measured, {"linestyle": "", "marker": "o"}),
    "wall of the extended scan": (hpc_gfmd.spectrum_of(again), {"linestyle": ":"}),
}
for name, (spectrum, how) in lines.items():
    ax.loglog(spectrum.q / 1e6, spectrum.C * 1e24, label=name, **how)
highest = lines["isotropic wall"][0]
shown = (highest.q >= highest.q[0]) & (highest.C > 1e-9 * highest.C.max())
ax.set_ylim(highest.C[shown].min() * 1e24 / 10, highest.C.max() * 1e24 * 10)
ax.set(xlabel="$q$ (µm$^{-1}$)", ylabel="$C(q)$ (µm$^4$)", title="power spectra")
ax.xaxis.set_minor_locator(NullLocator())
ax.legend()
fig.savefig("spectrum.png", dpi=200)
