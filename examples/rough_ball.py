"""A rough ball on a flat: how far roughness spreads the pressure, over the load.

`radius` puts a ball under the roughness. The effective contact radius is that of the Hertz contact
whose pressure lies as far from the axis in the mean (Greenwood and Tripp 1967); it is Hertz's own
where alpha, the rms height over Hertz's approach, is below about 0.05.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import hpc_gfmd
from hpc_gfmd.theory.elastic import Hertz

n = int(sys.argv[1]) if sys.argv[1:] else 512  # points along each axis
R, L, E_star, h_rms = 5e-3, 200e-6, 1e11, 20e-9  # m, m, Pa, m
forces = np.geomspace(0.01, 10, 7)  # N
ratios = {"hurst": 0.8, "L_over_lam_l": 8, "lam_l_over_lam_s": 8, "lam_s_over_a": n / 64, "seed": 1}
ball = hpc_gfmd.make_surface(
    "self-affine", h_rms=h_rms, radius=R, boundary="free", physical_sizes=(L, L), **ratios
)
solutions = hpc_gfmd.solve(ball, force=forces, E_star=E_star)

fig, (profile, spread) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
r = np.hypot(*np.meshgrid(*[(np.arange(n) - n // 2) * L / n] * 2))
rings = np.linspace(0, L / 2, 41)
for k, (F, solution) in enumerate(zip(forces, solutions)):
    hertz = Hertz(R, F, E_star)
    effective = 16 / (3 * np.pi) * np.average(r, weights=solution.pressure)
    spread.semilogx(h_rms / hertz.approach, effective / hertz.a, f"C{k}o")
    if k in (1, 3, 5):
        mean = np.histogram(r, rings, weights=solution.pressure)[0] / np.histogram(r, rings)[0]
        label = f"{F:.3g} N, $\\alpha$ = {h_rms / hertz.approach:.2g}"
        profile.stairs(mean / 1e9, rings * 1e6, baseline=None, color=f"C{k}", label=label)
        profile.plot(rings * 1e6, hertz.pressure(rings) / 1e9, "0.4", linewidth=0.8)
spread.axvline(0.05, color="0.4", linewidth=0.8)
spread.axhline(1, color="0.4", linewidth=0.8, label="Hertz")
profile.set(xlabel="$r$ (µm)", ylabel="mean pressure on a ring (GPa)", xlim=(0, 80))
spread.set(xlabel=r"$\alpha = h_\mathrm{rms}/\delta$", ylabel="effective radius / Hertz's")
profile.legend(frameon=False)
spread.legend(frameon=False)
fig.savefig("rough_ball.png", dpi=200)
