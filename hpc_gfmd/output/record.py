"""The result file while it is being written.

Everything finished goes at once into the folder OUT.h5.partial, one file per load step, and at the
end all of it becomes OUT.h5 in one rename. So nothing finished is lost, and nothing half-written
has a final name. Beside them lies the gap of a load that was stopped in its middle.
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
    """The result file of one run, used in a `with` statement. All methods are collective.

    Parameters
    ----------
    comm : Comm
        All ranks that write.
    path : path
        The result file, OUT.h5.
    n : (int, int)
        Points of the surface.
    rows : (int, int)
        Start and stop of this rank's rows, which may be none.
    head : dict
        Root attributes, among them `scene` (TOML text), `identity` (of the scene), `versions`.
    surface : dict
        Attributes of the surface.
    resume : bool
        Whether to go on with an interrupted run of the same identity, and to leave what a later one
        can go on with.
    force : bool
        Whether to begin anew, and to replace even what is no result of this scene.
    about : dict
        What the numbers of the steps are, see `contact.all_numbers`.
    **how
        As for `parallel.h5.write_file`.

    Attributes
    ----------
    finished : dict
        Attributes of the finished loads by their indices.
    resumed : bool
        Whether an interrupted run goes on.
    notes : list of str
        What was found, a line each.
    earlier : dict
        Root attributes of the run that is resumed which hold for this one, too.

    Raises
    ------
    SceneError
        As `claim.claim`.
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
        """Begin: from now on the run can be resumed. Raises GfmdError on every rank."""
        try:
            self._head = {"io": self._io_way(), **self._head}
            self.update()
        except GfmdError:
            self.close()
            raise
        return self

    def _io_way(self) -> str:
        """Return how fields are written; a note says why not by MPI-IO where that is there."""
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
        """Add to the head of the result. Collective.

        Parameters
        ----------
        surface : dict, optional
            Attributes of the surface.
        height_field : ndarray, shape (rows, n_y), optional
            Local slab of the heights, kept once for all load steps.
        **head
            Root attributes.

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
        """Write one finished load step. Collective.

        Parameters
        ----------
        index : int
            Number of the load, from 0.
        attributes : dict
            Its numbers by name; None: it has none.
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
        """Write the gap of a load that is stopped in its middle, from which it can go on.

        Parameters
        ----------
        grid : Grid
            The grid of the solver, which is larger than the surface where that ends.
        index : int
            Of the load.
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
        """Read the gap of the load that was stopped, None if there is none.

        Raises SceneError as `read_checkpoint`.
        """
        path = self.partial / STATE
        identity = self._head["identity"]
        return on_rank_0(self.comm, f"reading {path}", lambda: read_checkpoint(path, identity))

    def take(self, result: Result) -> None:
        """Take all load steps of a result, numbered anew, which `finish` writes."""
        result = replace(result, indices=list(range(len(result.steps))))
        self.finished = result.numbered
        self._fields = result.datasets

    def finish(self, status: str) -> None:
        """Compose OUT.h5 from the finished steps, put it in place of any older one and remove the
        folder.

        Raises GfmdError on every rank if that fails, or the fields of a step are damaged; the
        finished steps stay in the folder.
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
        """Give the file back; what is there can be resumed, unless it is not to be kept or was
        never begun."""
        if self._lock is not None:
            release(self.partial, self._lock, keep)
            self._lock = None

    def __exit__(self, kind: type | None, *_: object) -> None:
        refused = kind is not None and issubclass(kind, SceneError)
        begun = bool(self.finished) or self.resumed
        self.close(keep=self._resume and (begun or not refused))  # a wrong scene leaves nothing

    def _write(
        self, path: Path, status: str, steps: dict[str, dict], fields: dict[str, Any]
    ) -> dict[str, Stored]:
        """Write a file of the unfinished result, numbers and fields; returns where its fields are.
        Collective."""
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
    """Return the time, as it stands in a file."""
    return datetime.now(UTC).isoformat(timespec="seconds")
