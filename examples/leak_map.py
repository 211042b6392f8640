"""Where a seal leaks: the gap handed to reynoldsflow (`pip install reynoldsflow`), a solver of
Reynolds' equation for large maps and for rings."""

import sys

import matplotlib.pyplot as plt
import numpy as np
from reynoldsflow.transport import compute_total_flux, solve_fluid_problem

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 512
wall = hpc_gfmd.make_surface(
    "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=n // 8, lam_s_over_a=4, seed=1
)
solution = hpc_gfmd.solve(wall, p_star=0.15, observables=["critical_gap"])
gap, _, flux = solve_fluid_problem(solution.gap / solution.h_rms)
flow, _ = compute_total_flux(gap, flux, n)
estimate = (solution.value("critical_gap_x") / solution.h_rms) ** 3
print(f"flow {flow:.4g}, from the critical gap {estimate:.4g}, times dp h_rms^3/(12 viscosity)")

fig, ax = plt.subplots(figsize=(4.4, 4), layout="constrained")
speed = np.ma.masked_invalid(np.hypot(flux[..., 0], flux[..., 1]))
image = ax.imshow(np.sqrt(speed).T, origin="lower", cmap="viridis", extent=(0, 1, 0, 1))
ax.contourf(solution.contact.T, [0.5, 1.5], colors="0.85", extent=(0, 1, 0, 1))
ax.set(xlabel="$x/L$: the flow", ylabel="$y/L$")
fig.colorbar(image, label="root of the local flow", shrink=0.8)
fig.savefig("leak_map.png", dpi=120)
