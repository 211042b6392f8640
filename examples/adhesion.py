"""A sticky wall: contact area and mean gap as the bodies come together and are pulled apart."""

import sys

import matplotlib.pyplot as plt

import hpc_gfmd

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 256
wall = hpc_gfmd.make_surface(
    "self-affine",
    hurst=0.8,
    L_over_lam_l=2,
    lam_l_over_lam_s=n / 32,
    lam_s_over_a=16,
    g_rms=1.0,
    physical_sizes=(n / 16, n / 16),  # in shortest waves
    seed=1,
)
adhesion = {"work": 0.3, "range": 0.2}  # in E* lam_s and lam_s
pressures = [0.0, 0.02, 0.05, 0.1, 0.2, 0.3]
approach = hpc_gfmd.solve(wall, pressures, adhesion=adhesion, fields=())
down = [*reversed(pressures), *(-0.02 * k for k in range(1, 20))]
retraction = hpc_gfmd.solve(wall, down, adhesion=adhesion, branch="retraction", fields=())

fig, axes = plt.subplots(1, 2, figsize=(7, 3.2), layout="constrained")
held = [solution for solution in retraction if solution.status == "converged"]
for ax, name, label in zip(axes, ("a_r", "gap_mean"), ("contact area", r"mean gap/$\lambda_s$")):
    for loads, look, branch in ((approach, "o-", "approach"), (held, "s-", "retraction")):
        ax.plot([s.p for s in loads], [s.value(name) for s in loads], look, ms=3, label=branch)
    if retraction.pull_off is not None:
        ax.axvline(retraction.pull_off, color="0.5", ls=":", lw=0.8, label="pull-off")
    ax.set(xlabel="mean pressure $p/E^*$", ylabel=label)
axes[0].legend()
fig.savefig("adhesion.png", dpi=150)
if retraction.pull_off is not None:
    print(f"pull-off at {retraction.pull_off:.2f} E*")
