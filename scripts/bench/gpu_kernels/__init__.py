"""Twins of kernels for fields on a GPU: in a file of the same name, a function of the same name,
arguments and results. They need numba-cuda, and nothing else of this package.

A twin works on a whole periodic surface in single precision, without hardness and attraction, with
an even number of points along both axes. What it does not need of its arguments it ignores.
"""
