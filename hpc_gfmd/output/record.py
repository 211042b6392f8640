"""The result file while it is written.

Every finished load is written at once into the folder OUT.h5.partial, one file per load step. At
the end all of them become OUT.h5 in one rename. So nothing finished is lost, and an incomplete file
never has the final name. The folder also holds the gap of a load that was stopped before it
converged.
"""

import os
from contextlib import AbstractContextManager
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..parallel.comm import Comm
from ..parallel.grid import Grid
from ..parallel.guard import on_rank_0
from ..parallel.h5 import Stored, write_file
from ..parallel.mpi_io import io_way, mpi_io_obstacle
from ..util.errors import GfmdError, SceneError
from .claim import EarlierRun, claim
from .describe import SIGNS, describe, set_attributes
from .folder import HEAD, STATE, followed, partial_folder, release
from .numbers import About
from .read import CHECKPOINT, FORMAT, read_checkpoint
from .result import FORMAT_VERSION, Result, group_of


class RunFile(AbstractContextManager):
    """The result file of one run, for use in a `with` statement.

    All methods are collective, `take` and `close` too, although these two send no message.

    Creating it locks the folder OUT.h5.partial and may empty it (see `claim.claim`). Leaving the
    `with` statement releases the lock; what is finished stays in the folder and can be resumed,
    unless `resume` is False, or the scene was refused (SceneError) before any load was finished.

    Parameters
    ----------
    comm : Comm
        All ranks that write.
    path : path
        The result file, OUT.h5; a symbolic link stands for its target.
    n : (int, int)
        Points of the surface.
    rows : (int, int)
        Start and stop of this rank's rows; there may be none.
    head : dict
        Root attributes, among them `scene` (TOML text), `identity` (of the scene), `versions`.
    surface : dict
        Attributes of the surface.
    resume : bool
        Whether to continue an interrupted run of the same identity, and to leave a folder that a
        later run can continue.
    force : bool
        Whether to start from the beginning, and to replace any file at `path`.
    about : dict, optional
        {name: (meaning, unit)} of the numbers, see `contact.all_numbers`; by default unknown.
    **how
        As for `parallel.h5.write_file`.

    Attributes
    ----------
    finished : dict
        Attributes of the finished loads, by number, in ascending order; those of a resumed run are
        among them.
    resumed : bool
        Whether an interrupted run is continued.
    notes : list of str
        Notes on earlier runs and on the way of writing, one line each.
    earlier : dict
        Root attributes of the resumed run that this run keeps (start time, origin of the heights).

    Raises
    ------
    SceneError
        As `claim.claim`, on every rank.
    """

    def __init__(
        self,
        comm: Comm,
        path: str | os.PathLike,
        n: Any,
        rows: tuple[int, int],
        head: dict,
        surface: dict,
        *,
        resume: bool = True,
        force: bool = False,
        about: About | None = None,
        **how: Any,
    ):
        self.comm = comm
        self.path = followed(path)
        self.partial = partial_folder(path)
        self._points = ((int(n[0]), int(n[1])), rows)
        self._how = how
        self._about = about or {}
        self._resume = resume
        self._surface = dict(surface)
        self._lock: int | None = None  # on rank 0

        def claimed() -> EarlierRun:
            """Lock the folder and store the descriptor; return what an earlier run has left."""
            self._lock, earlier_run = claim(self.path, head.get("identity"), resume, force)
            return earlier_run

        earlier_run = on_rank_0(comm, f"opening {self.path}", claimed)
        self.resumed = earlier_run.is_resumed
        self.notes = earlier_run.notes
        self.finished = earlier_run.result.numbered
        self._fields = earlier_run.result.datasets
        kept = earlier_run.result.head
        self.earlier = {name: kept[name] for name in ("start_time", "heights") if name in kept}
        self._head = {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "ranks": comm.size,
            "signs": SIGNS,
            "start_time": _now(),
            **self.earlier,
            **head,
        }

    def __enter__(self) -> Self:
        """Write head.h5, after which the run can be resumed. Raises GfmdError on every rank."""
        try:
            self._head = {"io": self._io_way(), **self._head}
            self.update()
        except GfmdError:
            self.close()
            raise
        return self

    def _io_way(self) -> str:
        """Return how fields are written: "mpio" or "serial" (by rank 0). Collective.

        Adds a note if HDF5 has MPI-IO and it cannot be used here.
        """
        import h5py

        way = io_way(self.comm, self.partial / HEAD)
        if way == "serial" and self.comm.size > 1 and h5py.get_config().mpi:
            obstacle = mpi_io_obstacle(self.comm, self.partial / HEAD)
            self.notes = [
                *self.notes,
                f"{self.path}: rank 0 writes for all, because MPI-IO cannot ({obstacle})",
            ]
        return way

    def update(self, surface: dict | None = None, height_field: Any = None, **head: Any) -> None:
        """Add attributes and the heights to the head of the result, and write head.h5 again.

        Collective.

        Parameters
        ----------
        surface : dict, optional
            Attributes of the surface, which are added to those that were set before, or replace
            them.
        height_field : ndarray, shape (rows, n_y), optional
            Local slab of the heights, which are stored once for all load steps.
        **head
            Root attributes, likewise.

        Raises
        ------
        GfmdError
            On every rank, if it cannot be written.
        """
        self._surface |= surface or {}
        self._head |= head
        heights = {} if height_field is None else {"surface/heights": height_field}
        self._fields |= self._write(self.partial / HEAD, "running", {}, heights)

    def write_step(
        self, index: int, attributes: dict, fields: dict[str, Any] | None = None
    ) -> None:
        """Write a finished load step to its file in the folder and add it to `finished`.

        Collective.

        Parameters
        ----------
        index : int
            Number of the load, from 0.
        attributes : dict
            Its numbers by name; those that are None are left out.
        fields : dict of ndarray, optional
            Local slabs, shape (rows, n_y), by name.

        Raises
        ------
        GfmdError
            On every rank, if it cannot be written; steps written before stay as they are.
        """
        attributes = {name: value for name, value in attributes.items() if value is not None}
        group = group_of(index)
        slabs = {f"{group}/{key}": data for key, data in (fields or {}).items()}
        self._fields |= self._write(
            self.partial / f"step-{index:04d}.h5", "running", {group: attributes}, slabs
        )
        self.finished = dict(sorted((self.finished | {index: attributes}).items()))

    def write_checkpoint(self, grid: Grid, index: int, gap: np.ndarray, numbers: dict) -> None:
        """Write the gap of a load that was stopped before it converged, to restart from.

        Collective. An earlier checkpoint is replaced.

        Parameters
        ----------
        grid : Grid
            The grid of the solver, which is larger than a surface with free edges.
        index : int
            Number of the load.
        gap : ndarray
            Local slab of the grid, in the program's unit.
        numbers : dict
            p, seconds, iterations and fft_pairs of the load so far, see `read_checkpoint`.

        Raises
        ------
        GfmdError
            On every rank, if it cannot be written.
        """
        name = group_of(index)
        groups = {
            "/": {
                "format": CHECKPOINT,
                "format_version": FORMAT_VERSION,
                "identity": self._head["identity"],
            },
            "surface": {"n": list(grid.n)},
            name: numbers,
        }
        write_file(
            self.comm,
            self.partial / STATE,
            grid.n,
            grid.rows,
            {f"{name}/gap": gap},
            lambda file: set_attributes(file, groups),
        )

    def checkpoint(self) -> Result | None:
        """Read what `write_checkpoint` has written; None if there is nothing. Collective.

        Raises SceneError as `read_checkpoint`, on every rank.
        """
        path = self.partial / STATE
        identity = self._head["identity"]
        return on_rank_0(self.comm, f"reading {path}", lambda: read_checkpoint(path, identity))

    def take(self, result: Result) -> None:
        """Replace the finished loads and their fields by those of a result, numbered from 0.

        Nothing is written before `finish`.
        """
        result = replace(result, indices=list(range(len(result.steps))))
        self.finished = result.numbered
        self._fields = result.datasets

    def finish(self, status: str) -> None:
        """Write OUT.h5 with all finished steps, replace an older file and remove the folder.

        Collective. `status` is that of the whole run. The lock is released. Raises GfmdError on
        every rank if writing fails or the stored fields of a step are damaged; then the finished
        steps stay in the folder, and the lock is held until the `with` statement ends.
        """
        self._head["end_time"] = _now()
        steps = {group_of(index): step for index, step in self.finished.items()}
        try:
            self._write(self.path, status, steps, self._fields)
        except GfmdError as error:
            if not self._resume:
                raise
            raise GfmdError(f"{error}; the finished steps are safe in {self.partial}") from error
        on_rank_0(self.comm, f"removing {self.partial}", lambda: self.close(keep=False))

    def close(self, keep: bool = True) -> None:
        """Release the lock, which rank 0 holds; does nothing if it is released, or on other ranks.

        The folder is kept if `keep` is set and the run has begun (head.h5 exists), and removed
        otherwise.
        """
        if self._lock is not None:
            release(self.partial, self._lock, keep)
            self._lock = None

    def __exit__(self, kind: type | None, *_: object) -> None:
        """Release the lock; keep what is finished for a later run, see the class."""
        refused = kind is not None and issubclass(kind, SceneError)
        begun = bool(self.finished) or self.resumed
        self.close(keep=self._resume and (begun or not refused))  # a wrong scene leaves nothing

    def _write(
        self, path: Path, status: str, steps: dict[str, dict], fields: dict[str, Any]
    ) -> dict[str, Stored]:
        """Write a file with the head, the surface, some steps and fields.

        `status` is that of the run. `fields` are local slabs, or Stored (where another file has
        one), by their path in the file. Replaces the file as a whole or not at all. Returns
        {path in the file: Stored} of the fields in the new file. Raises GfmdError on all ranks.
        Collective.
        """
        head = self._head | {"status": status}
        return write_file(
            self.comm,
            path,
            *self._points,
            fields,
            lambda file: describe(file, head, self._surface, steps, self._about),
            **self._how,
        )


def _now() -> str:
    """Return the present time as text, UTC, ISO 8601, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")
