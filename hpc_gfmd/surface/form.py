"""Whether a height map shows a form, such as a ball, and not only roughness."""

from collections.abc import Sequence

import numpy as np

from ..util.errors import SurfaceWarning
from ..util.quantities import prefixed

CURVED = 3.0  # sag over rms of the rest above which a map counts as curved (chosen by hand)
POINTS = 512  # along an axis at which the form is fitted, at most about twice as many


def form_notes(
    z: np.ndarray, sizes: tuple[float, ...], unit: str, axes: Sequence[int]
) -> list[SurfaceWarning]:
    """Return a note on a map that is curved along these axes: the sag, between middle and edges, of
    the best paraboloid without a mixed term.
    """
    every_row, every_column = (max(n // POINTS, 1) for n in z.shape)
    z = z[::every_row, ::every_column]
    x, y = (np.linspace(-1, 1, n) for n in z.shape)
    terms = [np.ones(z.shape), *np.meshgrid(x, y, indexing="ij")]
    terms += [terms[1] ** 2, terms[2] ** 2]
    design = np.stack([term.ravel() for term in terms], axis=1)
    factors, *_ = np.linalg.lstsq(design, (z - z.mean()).ravel())
    rest = np.std(z.ravel() - design @ factors)
    sags = [-float(factors[3 + axis]) for axis in (0, 1)]  # > 0: the middle is high
    curved = [axis for axis in axes if abs(sags[axis]) > CURVED * rest]
    if not curved:
        return []
    bent = " and ".join(
        f"along {'xy'[axis]} by {_text(abs(sags[axis]), unit)} (radius"
        f" {_text(sizes[axis] ** 2 / (8 * abs(sags[axis])), unit)})"
        for axis in curved
    )
    return [
        SurfaceWarning(
            f"the map is curved, {bent}, more than {CURVED:g} times the rms of the rest: a ball,"
            ' lens or cylinder ends where the map ends, boundary = "free"; detrend = "curvature"'
            " with radius puts the roughness on an ideal form"
        )
    ]


def _text(length: float, unit: str) -> str:
    scale, name = prefixed([length], unit)
    return f"{length / scale:.3g} {name}".strip()
