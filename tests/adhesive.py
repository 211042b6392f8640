"""Adhesive walls for tests, in units of the shortest wavelength, with rms slope 1 and E* = 1; a
ball and a wave with closed forms; minima of the energy by L-BFGS-B."""

import numpy as np
from adhesive_forms import AdhesiveWave, JohnsonKendallRoberts
from contacts import rough_wall, wave_numbers
from scipy.optimize import minimize

import hpc_gfmd
from hpc_gfmd.laws import law_named

LOAD = 0.05  # p*


def wall(points=8, waves=8, seed=1):
    """A self-affine wall; points: lam_s/a; waves: lam_l/lam_s."""
    return rough_wall(
        (2, waves, points), seed=seed, g_rms=1.0, physical_sizes=(2.0 * waves, 2.0 * waves)
    )


def attraction(kappa, reach, law="exponential"):
    """The table material.adhesion; kappa: work/(range^2 E* q_s/2)."""
    return {"work": kappa * np.pi * reach**2, "range": reach, "law": law}


def ball(n, tabor=1.0):
    """(surface, attraction, JKR theory) of a ball of radius 1 in a cell of size 1.

    Without load its JKR contact has a radius of 0.12.
    """
    work = 0.12**3 * 2 / (9 * np.pi)
    surface = hpc_gfmd.make_surface(
        "sphere", radius=1.0, n=(n, n), physical_sizes=(1.0, 1.0), boundary="free"
    )
    adhesion = {"work": work, "range": float(np.cbrt(work**2)) / tabor}
    return surface, adhesion, JohnsonKendallRoberts(1.0, work)


def wave(ell, n):
    """(arguments of hpc_gfmd.solve, exact theory) of Johnson's wave with alpha = 0.3.

    ell: process zone over the wavelength.
    """
    work = (0.3 * np.pi) ** 2 / 2
    arguments = {
        "heights": np.cos(2 * np.pi * np.arange(n) / n)[:, None],
        "physical_sizes": (1.0, 1.0 / n),
        "adhesion": {"work": work, "range": float(np.sqrt(ell * work))},
        "fields": (),
    }
    return arguments, AdhesiveWave(work)


def energy_of(surface, adhesion, load):
    """The function of a flattened gap that returns its energy, summed over points, and the
    derivatives of that."""
    h = surface.heights.max() - surface.heights
    K = wave_numbers(h.shape, surface.sizes) / 2
    law = law_named(adhesion["law"], adhesion["work"], adhesion["range"])

    def energy(flat_gap):
        g = flat_gap.reshape(h.shape)
        w = np.fft.ifft2(K * np.fft.fft2(g - h)).real
        total = np.sum(0.5 * (g - h) * w + load * g + law.energy(g))
        return total, (w + load + law.traction(g)).ravel()

    return energy


def minimum_near(g, energy):
    """The gap of the minimum of the energy to which descent from a gap comes."""
    options = {"maxiter": 20000, "maxfun": 40000, "ftol": 1e-16, "gtol": 1e-11, "maxcor": 30}
    bounds = [(0, None)] * g.size
    best = minimize(energy, g.ravel(), jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return best.x.reshape(g.shape)
