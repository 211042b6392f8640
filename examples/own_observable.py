"""An observable of your own: which share of the load do the most loaded parts of the contact carry?

Any function of a solution will do. One that results should have by name, on any number of ranks, is
a file in hpc_gfmd/contact/.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")


def load_share(solution, shares):
    """Share of the load on the most loaded shares of the contact area."""
    pressure = np.sort(solution.pressure[solution.contact])[::-1]
    carried = np.append(0, np.cumsum(pressure, dtype=float)) / pressure.sum(dtype=float)
    return np.interp(shares, np.linspace(0, 1, len(carried)), carried)


n = int(sys.argv[1]) if sys.argv[1:] else 1024
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
shares = np.linspace(0, 1, 101)
fig, ax = plt.subplots(figsize=(3.6, 3), layout="constrained")
for solution in hpc_gfmd.solve(wall, p_star=[0.01, 0.1, 1.0]):
    ax.plot(
        100 * shares,
        100 * load_share(solution, shares),
        label=f"$p^*$ = {solution.p_star:.2g}, $a_r$ = {100 * solution.a_r:.0f} %",
    )
    print(
        f"p* = {solution.p_star:.3g}: a tenth of the contact carries"
        f" {100 * load_share(solution, 0.1):.0f} % of the load"
    )
ax.set(xlabel="share of the contact area (%)", ylabel="share of the load (%)")
ax.legend()
fig.savefig("own_observable.png", dpi=200)
