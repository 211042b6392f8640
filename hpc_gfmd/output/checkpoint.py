"""Where a run can go on, in the middle of a load or at its beginning: written aside, renamed, read back by any number of ranks."""

import json
from dataclasses import dataclass
from pathlib import Path

from ..errors import SceneError
from ..parallel import h5_inside
from ..parallel.guard import guarded
from ..parallel.h5 import Slab, Stored, intact, write_file
from . import check
from .read import opened, stored_field


@dataclass(frozen=True)
class Checkpoint:
    """step: index of the load; midway: in the middle of it, not at its beginning; seconds: spent on it so far; numbers: of
    Sweep.state; solver: its name; fields: of the state."""

    path: Path
    step: int
    midway: bool
    seconds: float
    numbers: dict
    solver: str
    fields: dict[str, Stored]
    n: tuple[int, int]

    def arrays(self, grid):
        """The local slabs of the state by name. Collective; raises SceneError where they cannot be read or are of another grid."""
        with guarded(grid.comm, f"reading {self.path}"):
            if self.n != tuple(grid.n):
                raise SceneError(f"{self.path}: belongs to a grid of {self.n[0]} x {self.n[1]} points")
            return {name: field.read(*grid.rows) for name, field in self.fields.items()}


def write_checkpoint(comm, path, grid, step, solver, state, seconds=None):
    """Collective. step: index of the load; solver: name; state: of Sweep.state; seconds: spent on the load, None at its beginning."""
    arrays, numbers = state
    head = {"step": step, "midway": seconds is not None, "seconds": seconds or 0.0, "solver": solver, "n": list(grid.n),
            "numbers": json.dumps(numbers)}
    fields = {name: Slab(data, grid.rows[0], tuple(grid.n)) for name, data in arrays.items()}
    write_file(comm, path, {"/": head}, fields)


def read_checkpoint(comm, path, solver):
    """The Checkpoint of a solver, None if there is none. Collective; raises SceneError if it cannot be read or is another's."""
    found = None
    with guarded(comm, f"reading {path}"):
        if comm.rank == 0 and Path(path).exists():
            found = _read_head(Path(path), solver)
    found = comm.bcast(found)
    if found is not None and not intact(comm, found.fields.values()):
        raise SceneError(f"{path}: the file is damaged")
    return found


def _read_head(path, solver):
    with opened(path) as file:
        head, n = dict(file.attrs), tuple(int(n) for n in file.attrs["n"])
        datasets = dict(h5_inside.items(file))
        for name, dataset in datasets.items():
            check.field(name, dataset, n)
        found = Checkpoint(path, int(head["step"]), bool(head["midway"]), float(head["seconds"]), json.loads(head["numbers"]),
                           str(head["solver"]), {name: stored_field(path, name, item) for name, item in datasets.items()}, n)
    if found.solver != solver:
        raise SceneError(f"{path}: a checkpoint of {found.solver}, allowed: of {solver}")
    return found
