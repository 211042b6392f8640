"""Rough surfaces: every kind of scene surface becomes the same `Surface`."""

from .build import Surface, build_surface, surface_size
from .cell import cell_of, grid_of

__all__ = ["Surface", "build_surface", "cell_of", "grid_of", "surface_size"]
