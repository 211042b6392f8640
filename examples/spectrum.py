"""Walls of one spectrum: isotropic, with a lay, with deep valleys, and finer than a scan shows.

The spectrum is constant down to 20 µm and falls with H = 0.8. A piece of the first wall is scanned
with a quarter of the points; its spectrum goes on with the exponent of its own end.
"""

import sys
import warnings

import matplotlib.pyplot as plt
import numpy as np

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
lay = {"peklenik": 5.0, "angle": 30.0, "shortest": f"{10 * spacing} um"}
walls = {
    "isotropic": hpc_gfmd.make_surface("spectrum", **laws),
    "Peklenik number 5, 30°": hpc_gfmd.make_surface("spectrum", **laws, **lay),
    "skewness −2, kurtosis 9": hpc_gfmd.make_surface(
        "spectrum", **laws, skewness=-2.0, kurtosis=9.0
    ),
}
part = walls["isotropic"].heights[: n // 2 : 4, : n // 2 : 4]
with warnings.catch_warnings():  # a scan that does not resolve its wall is the point here
    warnings.simplefilter("ignore", hpc_gfmd.SurfaceWarning)
    scan = hpc_gfmd.prepare_surface(
        part, physical_sizes=("50 um", "50 um"), unit="m", boundary="free"
    )
# without waves of less than four points of the scan, which are aliased
measured = hpc_gfmd.spectrum_of(scan).between(0, 2 * np.pi / (16e-6 * spacing))
extended = measured.extended(4e-6 * spacing)
extended.write("spectrum.csv")  # for make_surface("spectrum", path="spectrum.csv", ...)
print(*walls.values(), extended, sep="\n")

fig, axes = plt.subplots(2, 2, figsize=(7.2, 6.4), layout="constrained")
for ax, (name, wall) in zip(axes.flat, walls.items()):
    z = 1e6 * (wall.heights - wall.heights.mean()).T
    image = ax.imshow(z, origin="lower", extent=(0, 100, 0, 100), cmap="Greys_r")
    ax.set(title=name, xlabel="$x$ (µm)", ylabel="$y$ (µm)")
    fig.colorbar(image, ax=ax, label="$z$ (µm)")
whole = hpc_gfmd.spectrum_of(walls["isotropic"]).between(0, 1.5e6 / spacing)
lines = {
    "isotropic wall": (whole, "-"),
    "extended": (extended, "--"),
    "scan of it": (measured, "o"),
}
for name, (spectrum, style) in lines.items():
    axes[1, 1].loglog(spectrum.q / 1e6, spectrum.C * 1e24, style, label=name)
axes[1, 1].set(xlabel="$q$ (µm$^{-1}$)", ylabel="$C(q)$ (µm$^4$)", title="power spectra")
axes[1, 1].legend()
fig.savefig("spectrum.png", dpi=160)
