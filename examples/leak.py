"""What leaks through a seal: SciPy solves Reynolds' equation, div(gap^3 grad p) = 0, on the gap of
each load; beside it the estimate from the critical gap alone."""

import sys

import matplotlib.pyplot as plt
import numpy as np
from scipy.sparse import coo_array, csgraph, linalg

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")


def flow(gap):
    """Flow along x times 12 viscosities over the pressure drop, periodic along y: the points are
    square, and between two of them is the harmonic mean of gap^3."""
    point, first, last = np.arange(gap.size).reshape(gap.shape), gap.size, gap.size + 1
    k = np.append(gap.astype(float) ** 3, [np.inf, np.inf])  # the last two are the reservoirs
    a = np.concatenate([point[:-1].ravel(), point.ravel(), point[0], point[-1]])
    ends = np.repeat([first, last], gap.shape[1])
    b = np.concatenate([point[1:].ravel(), np.roll(point, -1, axis=1).ravel(), ends])
    a, b = (x[(k[a] > 0) & (k[b] > 0)] for x in (a, b))
    net = coo_array((2 / (1 / k[a] + 1 / k[b]), (a, b)), (last + 1, last + 1)).tocsr()
    part = csgraph.connected_components(net, directed=False)[1]  # 0 where the ends are apart
    net, p = csgraph.laplacian(net + net.T).tocsr(), np.append(np.zeros(first), [1.0, 0.0])
    inside = np.flatnonzero(part[:first] == part[first])
    p[inside] = linalg.spsolve(net[inside][:, inside], -(net @ p)[inside])
    return float((net @ p)[first]) * (part[first] == part[last])


loads = hpc_gfmd.solve(
    hpc_gfmd.make_surface(
        "self-affine",
        hurst=0.8,
        L_over_lam_l=2,
        lam_l_over_lam_s=int(sys.argv[1]) // 8 if sys.argv[1:] else 32,
        lam_s_over_a=4,
        seed=1,
    ),
    p_star=np.linspace(0.02, 0.22, 9),
    observables=["critical_gap"],
)
found = np.array([[flow(one.gap), one.value("critical_gap_x") ** 3] for one in loads])
tight = loads.p_star[found[:, 1].argmin()]  # the first load at which nothing leaks
found[found == 0] = np.nan  # is not on a logarithmic axis

fig, ax = plt.subplots(figsize=(4.5, 3.4), layout="constrained")
ax.semilogy(loads.p_star, found / loads[0].h_rms ** 3, "o-")
ax.axvline(tight, color="0.5", linestyle="--")
ax.legend(["Reynolds' equation", "critical gap cubed", "tight"])
ax.set(
    xlim=(None, 1.02 * tight),
    xlabel=r"pressure $p/(E^* g_\mathrm{rms})$",
    ylabel=r"flow $12 \eta Q/(\Delta p\, h_\mathrm{rms}^3)$",
)
fig.savefig("leak.png", dpi=150)
