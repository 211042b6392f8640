"""What a scene has to say of a table of a spectrum, found by reading it."""

import os
from math import ceil, floor, log10, pi
from pathlib import Path
from typing import Any

from ..scene.template import Suggestion
from ..util.quantities import prefixed
from .spectra import in_metres, of_isotropic_surface
from .spectrum_table import KINDS, read_spectrum_table

POINTS = 512  # along an axis of the scene


def spectrum_suggestion(path: str, folder: Path, user_keys: dict[str, Any]) -> Suggestion:
    """Suggest keys for a table of a spectrum: a cell as long as its longest wave."""
    q, C, dimension, unit = read_spectrum_table(
        path, user_keys.get("unit"), user_keys.get("dimension")
    )
    table = in_metres(q, C, dimension, unit)

    def length(value: float) -> Any:
        scale, name = prefixed([value], table.unit)
        return f"{value / scale:.6g} {name}" if name else float(f"{value:.6g}")

    longest, shortest = (2 * pi / end for end in (float(table.q[0]), float(table.q[-1])))
    L = _rounded_up(longest)
    finest = 2 * L / POINTS
    values = {
        "path": os.path.relpath(path, folder),
        "physical_sizes": [length(L), length(L)],
        "n": [POINTS, POINTS],
    }
    why = {"physical_sizes": "as long as the longest wave of the table, one realisation of it"}
    if finest > shortest * (1 + 1e-6):
        values["shortest"] = length(finest)
        why["shortest"] = f"two points; the table goes on to {length(shortest)}"
    about = [
        f"{path}: spectrum of {KINDS[dimension]}, {len(q)} rows, waves from {length(longest)} to"
        f" {length(shortest)}"
    ]
    roughness = (table if dimension == 2 else of_isotropic_surface(table)).roughness()
    about.append(f"{path}: h_rms = {length(roughness.h_rms)}, g_rms = {roughness.g_rms:.4g}")
    return Suggestion(values | user_keys, why=why, about=about, unit=table.unit)


def _rounded_up(length: float) -> float:
    step = 10.0 ** (floor(log10(length)) - 2)
    return ceil(length / step * (1 - 1e-9)) * step
