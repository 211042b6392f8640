"""A rough ball on a flat: how far roughness spreads the pressure, over the load.

`radius` puts a ball under the roughness. The effective contact radius is that of the Hertz contact
whose pressure lies as far from the axis in the mean (Greenwood and Tripp 1967). It is Hertz's own
where alpha, the rms height over Hertz's approach, is below about 0.05.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd
from hpc_gfmd.theory.elastic import Hertz

plt.style.use("hpc_gfmd.plotting.journal")

n = int(sys.argv[1]) if sys.argv[1:] else 512  # points along each axis
R, L, E_star, h_rms = 5e-3, 200e-6, 1e11, 20e-9  # m, m, Pa, m
forces = np.geomspace(0.01, 10, 7)  # N
ball = hpc_gfmd.make_surface(
    "self-affine",
    hurst=0.8,
    L_over_lam_l=8,
    lam_l_over_lam_s=8,
    lam_s_over_a=n / 64,
    seed=1,
    h_rms=h_rms,
    physical_sizes=(L, L),
    boundary="free",
    radius=R,
)
solutions = hpc_gfmd.solve(ball, force=forces, E_star=E_star)

fig, (profile, spread) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
x = (np.arange(n) + 0.5) * L / n - L / 2
r = np.hypot(x[:, None], x)
rings = np.linspace(0, L / 2, 41)
hertz = Hertz(R, forces, E_star)
alphas = h_rms / hertz.approach
means = np.array([np.average(r, weights=solution.pressure) for solution in solutions])
spread.semilogx(alphas, 16 / (3 * np.pi) * means / hertz.a, "o", label="rough ball")
for k in (1, 3, 5):
    sums, points = (np.histogram(r, rings, weights=w)[0] for w in (solutions[k].pressure, None))
    label = f"{forces[k]:.3g} N, $\\alpha$ = {alphas[k]:.2g}"
    profile.stairs(sums / points / 1e9, rings * 1e6, baseline=None, color=f"C{k}", label=label)
    smooth = np.linspace(0, Hertz(R, forces[k], E_star).a, 200)
    profile.plot(smooth * 1e6, Hertz(R, forces[k], E_star).pressure(smooth) / 1e9, "0.4", lw=0.8)
profile.plot([], [], "0.4", linewidth=0.8, label="smooth ball: Hertz")
spread.plot([alphas.min(), 0.05], [1, 1], "0.4", linewidth=0.8, label="Hertz, valid to 0.05")
profile.set(xlabel="$r$ (µm)", ylabel="mean pressure on a ring (GPa)", xlim=(0, 80))
spread.set(xlabel=r"$\alpha = h_\mathrm{rms}/\delta$", ylabel="effective radius / Hertz's")
for ax in (profile, spread):
    ax.legend(frameon=False)
fig.savefig("rough_ball.png", dpi=200)
