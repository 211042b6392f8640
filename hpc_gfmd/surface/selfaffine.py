"""The modes of self-affine random surfaces."""

from functools import partial
from typing import Any

import numpy as np

from ..kernels.random_waves import random_waves
from .modes import Modes

NO_TABLE = (np.empty(0), np.empty(0), np.empty((0, 0)))


def self_affine_modes(spec: Any, comm: Any) -> Modes:
    """Return the modes of a scene's [surface] of kind "self-affine"."""
    low = spec.L_over_lam_l
    rolloff = low * spec.lam_l_over_lam_r
    exponent = 1.0 + spec.hurst
    laws = (
        low,
        low * spec.lam_l_over_lam_s,
        np.array([0.0, rolloff]),
        np.ones(2),
        np.array([rolloff**-exponent, 1.0]),
        np.array([0.0, exponent]),
    )
    law = (np.uint64(spec.seed), False, spec.aspect, spec.stretch, laws, NO_TABLE)
    return Modes(partial(random_waves, n_y=spec.n[1], law=law))
