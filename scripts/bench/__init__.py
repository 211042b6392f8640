"""Measurements of speed: kernels, transforms, time against true error, and other codes on the same
surfaces."""
