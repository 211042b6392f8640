"""Passes over a height map, some rows at a time."""

ROWS = 64  # read at a time


def slabs(start: int, stop: int) -> list[tuple[int, int]]:
    """Cut the rows start <= i < stop into pieces (start, stop) of at most ROWS rows."""
    return [(row, min(row + ROWS, stop)) for row in range(start, stop, ROWS)]
