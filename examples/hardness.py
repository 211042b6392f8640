"""A metal that yields: the distribution of the pressure ends at the hardness, beside Persson's
theory with two absorbing ends."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd
from hpc_gfmd.theory import yielding

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 1024
E_star, hardness, g_rms = 115e9, 6e9, 0.06  # ground steel
wall = hpc_gfmd.make_surface(
    "self-affine",
    hurst=0.8,
    L_over_lam_l=2,
    lam_l_over_lam_s=n / 8,
    lam_s_over_a=4,
    g_rms=g_rms,
    seed=1,
)
loads = np.array([0.05, 0.2]) * hardness
solutions = hpc_gfmd.solve(wall, loads, E_star, hardness=hardness, distributions=["pressure"])

fig, ax = plt.subplots(figsize=(4.5, 3.4), layout="constrained")
for solution, colour in zip(solutions, ("C0", "C1")):
    a_r, a_plastic, found = (
        solution.a_r,
        solution.value("a_plastic"),
        solution.distribution("pressure"),
    )
    x, share = found["edges"], a_r * found["density"] * hardness
    elastic = x[1:] < hardness
    ax.stairs(
        share[elastic],
        x[: elastic.sum() + 1] / hardness,
        color=colour,
        label=f"p = {solution.p / hardness:g} H, {a_plastic:.1%} yields",
    )
    p = np.linspace(0, hardness, 301)
    of_theory = solution.p, hardness, g_rms, E_star
    theory = yielding.pressure_distribution(p, *of_theory)
    ax.plot(
        p / hardness,
        theory * hardness,
        "--",
        color=colour,
        label=f"Persson, {yielding.areas(*of_theory)[1]:.1%}",
    )
ax.set(xlabel="pressure $p/H$", ylabel="$H\\,P(p)$ in elastic contact", xlim=(0, 1))
fig.legend(loc="outside upper center", ncols=2)
fig.savefig("hardness.png", dpi=150)
