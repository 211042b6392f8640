"""Compiled inner loops: arrays and scalars in, arrays and sums out; only here is numba imported."""
