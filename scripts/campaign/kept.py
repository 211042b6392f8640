"""Truths of the loads of a wall, each solved once and kept in a file."""

import hashlib
import os
import tempfile
from pathlib import Path

import numpy as np

from .truth import DOUBTFUL, Contact, Truth


def cache_folder():
    """HPC_GFMD_TRUTHS, or a folder for temporary files."""
    return Path(
        os.environ.get("HPC_GFMD_TRUTHS") or Path(tempfile.gettempdir()) / "hpc-gfmd-truths"
    )


def truths(z, sizes, loads, free=(False, False)):
    """(Contact, [Truth]) of the loads p*, each from the cache if it is there."""
    contact = Contact(z, sizes, free)
    found, start = [], None
    for p_star in loads:
        name = repr((contact.n, tuple(map(float, sizes)), float(p_star))).encode()
        digest = hashlib.sha256(contact.h.tobytes() + contact.S.tobytes() + name).hexdigest()
        path = cache_folder() / f"{digest[:32]}.npz"
        truth = _read(path, contact.shape)
        if truth is None:
            near = start is not None and 0.5 < p_star / start.mean() < 2
            truth = contact.solve(p_star, start if near else None)
            if near and not truth.kkt < DOUBTFUL:
                truth = contact.solve(p_star)
            if truth.kkt < DOUBTFUL:
                _write(path, truth)
        start = truth.pressure
        found.append(truth)
    return contact, found


def _read(path, n):
    try:
        with np.load(path) as data:
            inside = np.unpackbits(data["inside"], count=n[0] * n[1]).astype(bool).reshape(n)
            p = np.zeros(n)
            p[inside] = data["pressure"]
            contact, gap_mean, ties_in, ties_out, kkt, rounds = data["numbers"]
    except (OSError, ValueError, KeyError, EOFError):
        return None
    truth = Truth(
        p, int(contact), float(gap_mean), int(ties_in), int(ties_out), float(kkt), int(rounds)
    )
    return truth if truth.kkt < DOUBTFUL else None


def _write(path, truth):
    path.parent.mkdir(parents=True, exist_ok=True)
    inside = truth.pressure > 0
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
        np.savez(
            file,
            inside=np.packbits(inside),
            pressure=truth.pressure[inside],
            numbers=[
                truth.contact,
                truth.gap_mean,
                truth.ties_in,
                truth.ties_out,
                truth.kkt,
                truth.rounds,
            ],
        )
    os.replace(file.name, path)
