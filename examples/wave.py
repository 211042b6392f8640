"""A wave on an elastic half-space: from a line of contact to full contact, and Westergaard's
solution.

The heights vary along one axis only; such walls are solved on that axis alone.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd
from hpc_gfmd.theory.elastic import Westergaard

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 1024
A, L = 0.01, 1.0
wave = hpc_gfmd.make_surface("wave", amplitude=A, n=(n, 8), physical_sizes=(L, 8 * L / n))
p_full = np.pi * A / L  # of full contact, in the unit of E*
pressures = p_full * np.array([0.01, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95])
solutions = hpc_gfmd.solve(wave, pressures, accuracy=1e-4)

fig, (profile, curve) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
x, fine = np.arange(n) * L / n, np.linspace(0, p_full, 200)
for k, solution in enumerate(solutions[1:6:2]):
    exact = Westergaard(solution.p, A, L)
    profile.plot(
        x,
        np.roll(solution.pressure[:, 0], n // 2) / p_full,
        f"C{k}.",
        markersize=2,
        label=f"{solution.p / p_full:.2g}",
    )
    profile.plot(x, exact.pressure(x - L / 2) / p_full, "0.4", linewidth=0.8)
curve.plot(pressures / p_full, solutions.values("a_r"), "o", label="contact area $a_r$")
curve.plot(
    pressures / p_full,
    solutions.values("gap_mean") / A,
    "s",
    label=r"mean gap $\langle g \rangle/A$",
)
for exact in (Westergaard(fine, A, L).a_r, Westergaard(fine, A, L).gap_mean / A):
    curve.plot(fine / p_full, exact, "0.4", linewidth=0.8)
profile.set(xlabel="$x/L$", ylabel=r"$p/p_\mathrm{full}$", ylim=(-0.1, 2.6))
curve.set(xlabel=r"mean pressure $p_0/p_\mathrm{full}$")
profile.legend(title=r"mean pressure $p_0/p_\mathrm{full}$", ncols=3, markerscale=3)
curve.legend()
fig.savefig("wave.png", dpi=200)
