"""Kernels of an iteration for fields on a GPU, compiled by numba.

They work on a whole periodic surface in single precision, without hardness and attraction, with an
even number of points along both axes.
"""

import numpy as np

if not hasattr(np, "row_stack"):  # numba-cuda still looks for it, new versions of NumPy lack it
    np.row_stack = np.vstack  # noqa: NPY201
