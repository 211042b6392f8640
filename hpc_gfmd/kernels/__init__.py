"""Compiled inner loops. Arrays and scalars in, arrays and partial sums out; the only place that
imports numba."""
