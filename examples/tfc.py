"""How far a simulation is from the continuum: kappa = a_r/p* over the grid spacing, as counted,
edge-corrected, and extrapolated.

eps_t = lam_l/L, eps_f = lam_s/lam_l and eps_c = a/lam_s are 0 in the thermodynamic, fractal and
continuum (TFC) limits.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd
from hpc_gfmd.theory import tfc

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 4096
points = [2, 4, 8]  # lam_s/a, on the same wall
p_star, ratio = 0.00707, n // 16
found = []
for lam_s_over_a in points:
    wall = hpc_gfmd.make_surface(
        "self-affine",
        hurst=0.8,
        L_over_lam_l=2,
        lam_l_over_lam_s=ratio,
        lam_s_over_a=lam_s_over_a,
        seed=2,
    )
    found.append(hpc_gfmd.solve(wall, p_star=p_star))
eps_c = 1 / np.array(points)
limits = [
    tfc.extrapolate(
        one.kappa,
        "kappa",
        hurst=0.8,
        p_star=p_star,
        eps_t=1 / 2,
        eps_f=1 / ratio,
        eps_c=eps,
        table=tfc.our_table(),
    )
    for one, eps in zip(found, eps_c)
]  # (value, its uncertainty, the terms); fitted around eps_f = 1/1024

fig, ax = plt.subplots(figsize=(3.6, 3.6), layout="constrained")
ax.plot(eps_c, [one.kappa for one in found], "o-", label="as counted")
ax.plot(eps_c, [one.observable("kappa_corrected") for one in found], "s-", label="edge-corrected")
ax.errorbar(
    eps_c,
    [value for value, _, _ in limits],
    [sigma for _, sigma, _ in limits],
    fmt="^-",
    label="this wall, taken to the TFC limit\n(walls of this size scatter by 0.1)",
)
# docs/study/limit.md
ax.axhspan(1.855 - 0.014, 1.855 + 0.014, color="0.8", label="TFC limit of many walls, 1.855(14)")
ax.axhline(1.93, color="0.4", linestyle="--", label="the same, Prodanov et al. (2014)")
ax.set(xlabel=r"$\epsilon_c = a/\lambda_s$", ylabel=r"$\kappa = a_r/p^*$", xlim=(0, 0.55))
fig.legend(loc="outside upper center")
fig.savefig("tfc.png", dpi=200)
