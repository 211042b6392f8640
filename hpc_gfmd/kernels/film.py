"""The film that closes the holes of a height map: a missing point is the mean of its four
neighbours; beyond an edge of the map a point is its own neighbour.

Missing points are given by runs: i, and begin and end of j. Vectors have a number for each of them,
in this order; the heights of a film are on the grid, 0 at all other points.
"""

from .jit import inline, kernel


@inline
def around(z, i, j):
    """Return the sum of the four neighbours of a point."""
    n_x, n_y = z.shape
    along_x = z[max(i - 1, 0), j] + z[min(i + 1, n_x - 1), j]
    return along_x + z[i, max(j - 1, 0)] + z[i, min(j + 1, n_y - 1)]


@kernel
def smooth(heights, right, runs, blocks):
    """Sweep once over a film, and add what its equations then lack to blocks of 2 x 2 points."""
    k = 0
    for run in range(len(runs)):
        i = runs[run, 0]
        for j in range(runs[run, 1], runs[run, 2]):
            heights[i, j] = (right[k] + around(heights, i, j)) / 4
            k += 1
    k = 0
    for run in range(len(runs)):
        i = runs[run, 0]
        for j in range(runs[run, 1], runs[run, 2]):
            blocks[i // 2, j // 2] += right[k] + around(heights, i, j) - 4 * heights[i, j]
            k += 1


@kernel
def gather(heights, runs, vector):
    """Take a vector from a grid."""
    k = 0
    for run in range(len(runs)):
        i = runs[run, 0]
        for j in range(runs[run, 1], runs[run, 2]):
            vector[k] = heights[i, j]
            k += 1


@kernel
def correct(heights, right, runs, blocks):
    """Raise each block, sweep backwards, and return the product of heights and right-hand side."""
    for run in range(len(runs)):
        i = runs[run, 0]
        for j in range(runs[run, 1], runs[run, 2]):
            heights[i, j] += blocks[i // 2, j // 2]
    product = 0.0
    k = len(right)
    for run in range(len(runs) - 1, -1, -1):
        i = runs[run, 0]
        for j in range(runs[run, 2] - 1, runs[run, 1] - 1, -1):
            k -= 1
            heights[i, j] = (right[k] + around(heights, i, j)) / 4
            product += right[k] * heights[i, j]
    return product


@kernel
def turn(direction, beta, heights, runs):
    """Make both heights and direction heights + beta direction; return the curvature along it."""
    k = 0
    for run in range(len(runs)):
        i = runs[run, 0]
        for j in range(runs[run, 1], runs[run, 2]):
            direction[k] = heights[i, j] + beta * direction[k]
            heights[i, j] = direction[k]
            k += 1
    curvature = 0.0
    for run in range(len(runs)):
        i = runs[run, 0]
        for j in range(runs[run, 1], runs[run, 2]):
            curvature += heights[i, j] * (4 * heights[i, j] - around(heights, i, j))
    return curvature


@kernel
def move(z, runs, direction, step, scale, right):
    """Move the missing heights of a map along a direction; write what their equations then lack, in
    units of scale, to `right`, and return the largest of it.
    """
    k = 0
    for run in range(len(runs)):
        i = runs[run, 0]
        for j in range(runs[run, 1], runs[run, 2]):
            z[i, j] += step * direction[k]
            k += 1
    largest = 0.0
    k = 0
    for run in range(len(runs)):
        i = runs[run, 0]
        for j in range(runs[run, 1], runs[run, 2]):
            lack = (around(z, i, j) - 4 * z[i, j]) / scale
            right[k] = lack
            largest = max(largest, abs(lack))
            k += 1
    return largest
