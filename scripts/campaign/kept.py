"""Truths of the loads of a wall, which are solved once and cached in files."""

import hashlib
import os
import tempfile
from dataclasses import asdict
from pathlib import Path

import numpy as np

from .truth import DOUBTFUL, Contact, Truth

ABOVE_LOADS = 1.1  # smallest hardness over the largest load


def cache_folder():
    """Return the folder HPC_GFMD_TRUTHS, or one for temporary files."""
    return Path(
        os.environ.get("HPC_GFMD_TRUTHS") or Path(tempfile.gettempdir()) / "hpc-gfmd-truths"
    )


def truths(z, sizes, loads, free=(False, False), hardness=None, hardness_star=None):
    """Return the contact, the truths of its loads and the hardness in units of p*.

    Parameters
    ----------
    z : ndarray
        Heights.
    sizes : (float, float)
        Size of the cell.
    loads : sequence of float
        p* in the order of solving.
    free : (bool, bool)
        Whether x and y have free edges.
    hardness : float, optional
        Over the largest pressure of the loads without one; it is at least ABOVE_LOADS times the
        largest load.
    hardness_star : float, optional
        In units of p*.

    Returns
    -------
    contact : Contact
    exact : list of Truth
    hardness : float or None
    """
    contact = Contact(z, sizes, free)
    if hardness_star is not None:
        return contact, _truths(contact, sizes, loads, hardness_star), hardness_star
    elastic = _truths(contact, sizes, loads)
    if hardness is None:
        return contact, elastic, None
    largest_pressure = max(truth.pressure.max() for truth in elastic)
    hardness = float(max(hardness * largest_pressure, ABOVE_LOADS * max(loads)))
    return contact, _truths(contact, sizes, loads, hardness), hardness


def _truths(contact, sizes, loads, *hardness):
    """Return the truths of the loads, each from the cache or solved from the previous one."""
    exact = []
    start = None
    for p_star in loads:
        name = repr((contact.n, tuple(map(float, sizes)), float(p_star), *hardness)).encode()
        digest = hashlib.sha256(contact.h.tobytes() + contact.S.tobytes() + name).hexdigest()
        path = cache_folder() / f"{digest[:32]}.npz"
        truth = _read(path)
        if truth is None or not truth.kkt < DOUBTFUL:
            is_near = start is not None and 0.5 < p_star / start.mean() < 2 and not hardness
            truth = contact.solve(p_star, start if is_near else None, *hardness)
            if is_near and not truth.kkt < DOUBTFUL:
                truth = contact.solve(p_star)
            _write(path, truth)
        start = truth.pressure
        exact.append(truth)
    return exact


def _read(path):
    try:
        with np.load(path) as data:
            numbers = {name: data[name][()] for name in data.files}
        return Truth(**numbers)
    except (OSError, ValueError, TypeError, EOFError):
        return None


def _write(path, truth):
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
        np.savez_compressed(file, **asdict(truth))
    os.replace(file.name, path)
