"""A sphere on an elastic half-space, pressed with five forces: the profiles of the pressure and the
radius of the contact, and Hertz.

The edges are free (boundary="free"): the sphere has no periodic images, and its arrays have the
size of the nominal area.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd
from hpc_gfmd.theory.elastic import Hertz

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 256  # points along each axis
R, L, E_star = 1e-3, 80e-6, 1e9  # m, m, Pa
forces = np.array([0.3, 1, 2, 5, 9]) * 1e-3  # N
ball = hpc_gfmd.make_surface("sphere", radius=R, n=(n, n), physical_sizes=(L, L), boundary="free")
solutions = hpc_gfmd.solve(ball, forces / L**2, E_star)

fig, (profile, radius) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
x = (np.arange(n) - n / 2) * L / n
for k, (F, solution) in enumerate(zip(forces, solutions)):
    hertz = Hertz(R, F, E_star)
    profile.plot(
        x * 1e6, solution.pressure[:, n // 2] / 1e6, f"C{k}.", markersize=3, label=f"{1e3 * F:.3g}"
    )
    profile.plot(x * 1e6, hertz.pressure(np.abs(x)) / 1e6, "0.4", linewidth=0.8)
    radius.plot(1e3 * F, 1e6 * np.sqrt(solution.a_r / np.pi) * L, f"C{k}o")
F = np.linspace(0, 1.1 * forces[-1], 99)
radius.plot(1e3 * F, 1e6 * Hertz(R, F, E_star).a, "0.4", linewidth=0.8)
profile.set(xlabel="$x$ (µm)", ylabel="$p$ (MPa)", xlim=(-50, 30))
radius.set(xlabel="$F$ (mN)", ylabel="contact radius (µm)")
profile.legend(title="$F$ (mN)", loc="upper left", frameon=False)
radius.set_title("lines: Hertz", loc="right")
fig.savefig("sphere.png", dpi=200)
