"""Rough surfaces: every kind of scene surface becomes the same `Surface`."""

from .build import Size, build_surface, open_surface, surface_size
from .cell import cell_of, grid_of
from .surface import ByHeights, Precision, Surface, precision_of

__all__ = [
    "ByHeights",
    "Precision",
    "Size",
    "Surface",
    "build_surface",
    "cell_of",
    "grid_of",
    "open_surface",
    "precision_of",
    "surface_size",
]
