"""Contacts of given fields, on slabs, for what is counted on them."""

from types import SimpleNamespace

import numpy as np

from hpc_gfmd.contact.contact import Contact
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.grid import Grid


def contact_of(g, p=None, sizes=(1.0, 1.0), comm=None, h=None, units=(1.0, 1.0), nominal=None):
    """A Contact with gap g and pressure p (default: 1 where g is 0) in units of (pressure,
    height)."""
    grid = Grid(np.shape(g), sizes, comm or SerialComm(), nominal=nominal)
    g = np.asarray(g, dtype=float)
    p = np.where(g > 0, 0.0, 1.0) if p is None else p
    mine = slice(*grid.rows)
    surface = SimpleNamespace(
        grid=grid,
        h=None if h is None else h[mine],
        g_rms=1.0,
        slope=1.0,
        h_rms=0.3 * units[1],
        height_unit=units[1],
        add_spectrum=None,
    )
    certificate = SimpleNamespace(contact=int(np.sum((g <= 0) & (p > 0))))
    return Contact(
        surface,
        units[0],
        1.0,
        np.ascontiguousarray(g[mine]),
        np.ascontiguousarray(p[mine]),
        "converged",
        certificate,
        1e-3,
    )


def random_fields(n, seed=0, share=0.3, smooth=1.5):
    """(g, p) of random patches that touch on about a share of all points."""
    from scipy import ndimage

    z = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal(n), smooth, mode="wrap")
    z -= np.quantile(z, share)
    return np.maximum(z, 0), np.maximum(-z, 0)
