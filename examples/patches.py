"""Contact patches: how many, how large, whether they percolate. What was not asked for with the
load is asked of the solution later."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 1024
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
solutions = hpc_gfmd.solve(wall, p_star=[0.02, 0.1, 0.3])

fig, axes = plt.subplots(2, 2, figsize=(7.2, 6.4), layout="constrained")
*maps, sizes = axes.flat
for k, (ax, solution) in enumerate(zip(maps, solutions)):
    patches, largest = solution.observable("patches"), solution.observable("patch_largest")
    percolates = solution.observable("percolation")
    solution.plot("contact", ax=ax)
    ax.set_title(f"$a_r$ = {100 * solution.a_r:.1f} %, {patches} patches", loc="left")
    spread = solution.distribution("patches")
    label = f"$p^*$ = {solution.p_star:.2g}"
    sizes.stairs(spread["density"], spread["edges"], baseline=None, color=f"C{k}", label=label)
    print(
        f"p* = {solution.p_star:.3g}: largest {largest:.3g} L^2, perimeter"
        f" {solution.observable('perimeter'):.3g} L, contact percolates along x:"
        f" {percolates['contact_percolates_x']}, gap: {percolates['gap_percolates_x']}"
    )
a = np.geomspace(spread["edges"][0], 1e-2)
sizes.plot(
    a,
    3 * spread["density"][0] * (a / a[0]) ** -(2 - 0.8 / 2),
    "0.4",
    linewidth=0.8,
    label="$A^{-(2 - H/2)}$",
)
sizes.set(xscale="log", yscale="log", xlabel="patch size $A/L^2$", ylabel="$P(A) L^2$")
sizes.legend()
fig.savefig("patches.png", dpi=200)
