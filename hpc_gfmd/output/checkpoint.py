"""Where a run can go on, in the middle of a load or at its beginning: written aside, renamed, read back by any number of ranks."""

import json
from dataclasses import dataclass
from pathlib import Path

from ..errors import SceneError
from ..parallel.guard import on_rank_0
from ..parallel.h5 import Stored, write_file
from .attributes import attributes_of, set_attributes
from .read import FORMAT, FORMAT_VERSION, fields_of, reading

KIND = f"{FORMAT} checkpoint"


@dataclass(frozen=True)
class Checkpoint:
    """step: index of the load; midway: in the middle of it, not at its beginning; seconds: spent on it so far; numbers: of
    Sweep.state; fields: of the state; n: points of its grid."""

    path: Path
    step: int
    midway: bool
    seconds: float
    numbers: dict
    fields: dict[str, Stored]
    n: tuple[int, int]

    def arrays(self, grid):
        """The local slabs of the state by name. Collective; raises GfmdError where they are damaged or of another grid."""
        if self.n != tuple(grid.n):
            raise SceneError(f"{self.path}: belongs to a grid of {self.n[0]} x {self.n[1]} points")
        return {name: field.slab(grid.comm, grid.rows) for name, field in self.fields.items()}


def write_checkpoint(comm, path, grid, step, solver, state, seconds=None, identity=""):
    """Collective. step: index of the load; solver: name; state: of Sweep.state; seconds: spent on the load, None at its beginning;
    identity: of the scene."""
    arrays, numbers = state
    head = {"format": KIND, "format_version": FORMAT_VERSION, "step": step, "midway": seconds is not None, "seconds": seconds or 0.0,
            "solver": solver, "identity": identity, "n": list(grid.n), "numbers": numbers}
    write_file(comm, path, grid.n, grid.rows, arrays, lambda file: set_attributes(file, head))


def read_checkpoint(comm, path, solver, identity=""):
    """The Checkpoint of a solver, None if there is none. Collective; raises SceneError if it cannot be read or is another's."""
    path = Path(path)

    def read():
        with reading(path, KIND) as file:
            head = attributes_of(file)
            if (head["solver"], head["identity"]) != (solver, identity):
                of = head["solver"] if head["solver"] != solver else "another scene"
                raise SceneError(f"{path}: a checkpoint of {of}, allowed: of {solver} and this scene")
            return Checkpoint(path, head["step"], head["midway"], head["seconds"], json.loads(head["numbers"]),
                              fields_of(path, file, head["n"]), tuple(head["n"]))

    return on_rank_0(comm, f"reading {path}", lambda: read() if path.exists() else None)
