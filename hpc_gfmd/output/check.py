"""What a result file may say: whoever shows, draws or continues a result can rely on it. Each check raises ValueError."""

from math import isfinite

TEXTS = ("status", "note", "precision", "kind", "unit", "pressure_unit", "prepared")
NUMBERS = ("p", "p_star", "a_r", "kappa", "kappa_corrected", "gap_mean", "gap_over_h_rms", "iterations", "fft_pairs", "wall_seconds",
           "a_r_error", "a_r_discretisation", "gap_error", "pressure_error", "hurst", "h_rms", "g_rms", "eps_t", "eps_f", "eps_c",
           "seed")
PAIRS = ("n", "physical_sizes")
_DEPTH = 3  # of lists in lists


def attributes(found: dict) -> dict:
    """The attributes of a surface or of a load step, as they came."""
    for name, value in found.items():
        if not _is_plain(value, _DEPTH):
            raise ValueError(f"{name} is neither a number nor a text nor a list of them")
        if name in TEXTS and not (isinstance(value, str) and value.isprintable()):
            raise ValueError(f"{name} is no line of text")
        if name in NUMBERS and not _is_number(value):
            raise ValueError(f"{name} is no number")
        if name in PAIRS and not (isinstance(value, list) and len(value) == 2 and all(map(_is_positive, value))):
            raise ValueError(f"{name} is no pair of positive numbers")
    if not all(isinstance(k, int) for k in found.get("n", ())):
        raise ValueError("n is no pair of whole numbers")
    return found


def field(name, dataset, n) -> None:
    """A dataset of a load step; n: grid points of the surface, or None where it has none."""
    if dataset.dtype.kind != "f":
        raise ValueError(f"{name} holds no real numbers but {dataset.dtype.kind!r}")
    if n is not None and tuple(dataset.shape) != tuple(n):
        raise ValueError(f"{name} has the shape {dataset.shape}, the surface has {tuple(n)} points")


def _is_number(value):
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_positive(value):
    return _is_number(value) and value > 0 and isfinite(value)


def _is_plain(value, depth):
    if isinstance(value, list):
        return depth > 0 and all(_is_plain(item, depth - 1) for item in value)
    return isinstance(value, bool | int | float | str)
