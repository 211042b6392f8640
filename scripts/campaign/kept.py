"""Truths of the loads of a wall, each solved once and kept in a file."""

import hashlib
import os
import tempfile
from dataclasses import asdict
from pathlib import Path

import numpy as np

from .truth import DOUBTFUL, Contact, Truth

MORE = 1.1


def cache_folder():
    """Return HPC_GFMD_TRUTHS, or a folder for temporary files."""
    return Path(
        os.environ.get("HPC_GFMD_TRUTHS") or Path(tempfile.gettempdir()) / "hpc-gfmd-truths"
    )


def truths(z, sizes, loads, free=(False, False), hardness=None, hardness_star=None):
    """Find (Contact, [Truth], the hardness in units of p*) of the loads p*, each Truth from the
    cache if it is there. hardness: over the largest pressure of the loads without one, but MORE
    than they are; hardness_star: or in units of p*."""
    contact = Contact(z, sizes, free)
    if hardness_star is not None:
        return contact, _truths(contact, sizes, loads, hardness_star), hardness_star
    found = _truths(contact, sizes, loads)
    if hardness is None:
        return contact, found, None
    hardness = float(max(hardness * max(t.pressure.max() for t in found), MORE * max(loads)))
    return contact, _truths(contact, sizes, loads, hardness), hardness


def _truths(contact, sizes, loads, *hardness):
    found, start = [], None
    for p_star in loads:
        name = repr((contact.n, tuple(map(float, sizes)), float(p_star), *hardness)).encode()
        digest = hashlib.sha256(contact.h.tobytes() + contact.S.tobytes() + name).hexdigest()
        path = cache_folder() / f"{digest[:32]}.npz"
        truth = _read(path)
        if truth is None or not truth.kkt < DOUBTFUL:
            near = start is not None and 0.5 < p_star / start.mean() < 2 and not hardness
            truth = contact.solve(p_star, start if near else None, *hardness)
            if near and not truth.kkt < DOUBTFUL:
                truth = contact.solve(p_star)
            _write(path, truth)
        start = truth.pressure
        found.append(truth)
    return found


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
