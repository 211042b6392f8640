"""Launches of device kernels, and sums over the threads of a block."""

import sys

import numpy as np
from numba import cuda

THREADS = 128  # of a block; a power of 2
STRIP = 32  # rows that a thread works on, one after another; even
ZERO = np.float32(0)
HALF = np.float32(0.5)
ONE = np.float32(1)


def library_of(array):
    """Return the module whose array this is: cupy, or numpy under the simulator."""
    return sys.modules[type(array).__module__.partition(".")[0]]


def view_of(argument):
    """Return a device array as numba takes it, without the synchronisation that it would make."""
    if hasattr(argument, "__cuda_array_interface__"):
        return cuda.as_cuda_array(argument, sync=False)
    return argument


def launch(kernel, blocks, threads, *arguments):
    """Launch a kernel without waiting for anything.

    Parameters
    ----------
    kernel : function
        Made by cuda.jit.
    blocks, threads : int or tuple of int
        Blocks of the launch, and threads of a block.
    *arguments : arrays and numbers
        Arrays are those of the device.
    """
    kernel[blocks, threads](*map(view_of, arguments))


def blocks_of(rows, columns):
    """Return the blocks of a launch in which each thread has one column of STRIP rows."""
    return -(-columns // THREADS), -(-rows // STRIP)


def partial_sums(array, blocks, count):
    """Return memory for the sums of each block of a launch, (blocks, count) float64, as `array`."""
    return library_of(array).empty((blocks[0] * blocks[1], count), np.float64)


@cuda.jit(device=True)
def block_number():
    """Return the number of this block in its launch."""
    return cuda.blockIdx.y * cuda.gridDim.x + cuda.blockIdx.x


@cuda.jit(device=True)
def sum_of_block(value, shared, partial, column):
    """Set partial[block, column] to the sum of a value over all threads of the block.

    All threads of the block call this together. shared: (THREADS,) float64, shared memory.
    """
    k = cuda.threadIdx.x
    cuda.syncthreads()
    shared[k] = value
    cuda.syncthreads()
    half = THREADS // 2
    while half > 0:
        if k < half:
            shared[k] += shared[k + half]
        cuda.syncthreads()
        half //= 2
    if k == 0:
        partial[block_number(), column] = shared[0]
