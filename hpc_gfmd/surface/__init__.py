"""Rough walls: every kind of scene surface becomes the same `Surface`."""

from .build import Surface, build_surface, surface_size

__all__ = ["Surface", "build_surface", "surface_size"]
