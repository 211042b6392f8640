"""The state of a solver in the middle of a load step: written aside, renamed, read back by any number of ranks."""

import json

import numpy as np

from ..errors import GfmdError, SceneError
from ..parallel.h5 import Slab, read_rows, write_file
from .read import opened


def write_checkpoint(comm, path, grid, step, solver, spent):
    """Collective. step: index of the load step; solver: its state is taken; spent: (FFT pairs, seconds) of the step so far."""
    arrays, numbers = solver.state()
    start = grid.rows[0]
    head = {"step": step, "solver": solver.name, "p0": solver.p0, "numbers": json.dumps(numbers), "ranks": comm.size,
            "pairs": spent[0], "seconds": spent[1], "dtype": solver.problem.dtype.name, "n": grid.n}
    fields = {name: Slab(data, start, grid.n) for name, data in arrays.items()}
    write_file(comm, path, {"/": head}, fields)


def read_checkpoint(comm, path, step, solver_name):
    """The checkpoint of a load step: {"arrays": function(grid) -> local slabs by name, "numbers", "p0", "pairs", "seconds", "dtype"},
    or None if there is none or it belongs to another step. Collective; an unreadable one counts as none."""
    found = None
    if comm.rank == 0:
        found = _read_head(path, step, solver_name)
    found = comm.bcast(found)
    if found is None:
        return None

    def arrays(grid):
        if tuple(found["n"]) != grid.n:
            raise SceneError(f"{path}: belongs to a grid of {found['n']} points")
        return {name: read_rows(path, name, grid.rows) for name in found["names"]}

    return found | {"arrays": arrays}


def _read_head(path, step, solver_name):
    try:
        with opened(path) as file:
            head = dict(file.attrs)
            if int(head["step"]) != step or head["solver"] != solver_name:
                return None
            return {"numbers": json.loads(head["numbers"]), "p0": float(head["p0"]), "pairs": float(head["pairs"]),
                    "seconds": float(head["seconds"]), "dtype": np.dtype(head["dtype"]), "names": list(file),
                    "n": [int(n) for n in head["n"]]}
    except (OSError, KeyError, ValueError, GfmdError, SceneError):
        return None
