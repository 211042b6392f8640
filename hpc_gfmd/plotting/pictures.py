"""All pictures of one result file."""

from pathlib import Path

import numpy as np

from ..errors import GfmdError, SceneError
from ..output.read import Result, read_result
from ..parallel.guard import one_line
from .curves import curves
from .distributions import distributions
from .maps import contact_maps
from .survey import survey
from .units import gap_unit, pressure_unit

MAX_STEPS = 4  # in maps and distributions
DRAWN = {"pressure", "gap"}


def plot_result(file, folder=None) -> list[Path]:
    """Draw what the file (a path or a Result) has and return the paths of the PNG files.

    folder: where contact_maps.png, distributions.png and curves.png go, made if it is missing; by default
    they lie beside the file and have its stem before their names. Maps and distributions need stored fields.
    Raises SceneError if the file cannot be read or has no finished step, or the folder cannot be made, and
    GfmdError if a field or a picture fails on the way.
    """
    result = file if isinstance(file, Result) else read_result(file)
    if not result.steps:
        raise SceneError(f"{result.path}: no finished load step yet, nothing to draw")
    prefix = "" if folder else f"{result.path.stem}_"
    folder = Path(folder or result.path.parent)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SceneError(f"{folder}: pictures cannot go there ({one_line(error)})") from None
    try:
        return _draw(result, folder, prefix)
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise GfmdError(f"drawing {result.path}: {one_line(error)}") from error


def _draw(result, folder, prefix) -> list[Path]:
    names = []
    stored = [DRAWN & set(fields) for fields in result.fields]
    most = max(stored, key=len)
    chosen = _evenly([k for k, names_there in enumerate(stored) if most and names_there == most])
    if chosen:
        surveys = [_survey(result, k) for k in chosen]
        for draw in (contact_maps, distributions):
            names.append(folder / f"{prefix}{draw.__name__}.png")
            draw(names[-1], result, chosen, surveys)
    names.append(folder / f"{prefix}curves.png")
    curves(names[-1], result)
    return names


def _survey(result, k):
    p_unit, _ = pressure_unit(result.steps[k])
    return survey(result.fields[k], p_unit, gap_unit(result.surface)[0])


def _evenly(indices):
    """At most MAX_STEPS of them, first and last included."""
    if len(indices) <= MAX_STEPS:
        return indices
    return [indices[k] for k in np.linspace(0, len(indices) - 1, MAX_STEPS).round().astype(int)]
