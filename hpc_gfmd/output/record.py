"""The result file while it is being written.

Everything finished goes at once into the folder OUT.h5.partial, one file per load step, and at the
end all of it becomes OUT.h5 in one rename. So nothing finished is lost, and nothing half-written
has a final name. Beside them lies the gap of a load that was stopped in its middle.
"""

import os
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from ..parallel.comm import Comm
from ..parallel.grid import Grid
from ..parallel.guard import on_rank_0
from ..parallel.h5 import Stored, write_file
from ..parallel.mpi_io import io_way, mpi_io_obstacle
from ..util.errors import GfmdError, SceneError, reason
from .describe import SIGNS, describe, set_attributes
from .folder import HEAD, STATE, acquire, clear, followed, partial_folder, step_files
from .numbers import About
from .read import (
    CHECKPOINT,
    FORMAT,
    FORMAT_VERSION,
    Result,
    group_of,
    read_checkpoint,
    read_partial,
    read_result,
)


class RunFile(AbstractContextManager):
    """The result file of one run. All methods are collective.

    path: OUT.h5; n: (n_x, n_y); rows: (start, stop) of this rank, may be empty; head: root
    attributes, among them `scene` (TOML text), `identity` (of the scene), `versions`; surface:
    attributes; resume: go on with an interrupted run of the same identity, and leave what a later
    one can go on with; force: begin anew, and replace even what is no result of this scene; about:
    what the numbers of the steps are, as contact.all_numbers gives it; how: as of
    parallel.h5.write_file.

    finished: attributes of the steps that are there, by their indices; resumed: whether an
    interrupted run goes on; notes: what was found, a line each; earlier: root attributes of the run
    that is resumed which hold for this one, too.
    Raises SceneError if the folder is missing or not writable, another run holds the file, or
    finished steps or a result would be lost that are not to be replaced.
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
        self.comm, self.path, self.partial = comm, followed(path), partial_folder(path)
        self._points, self._how, self._about = ((int(n[0]), int(n[1])), rows), how, about or {}
        self._lock: int | None = None
        self._resume = resume
        try:
            left, self.resumed, self.notes = on_rank_0(
                comm,
                f"opening {self.path}",
                lambda: self._claim(head.get("identity"), resume, force),
            )
            self.finished = left.numbered
            self._fields = left.datasets
            self.earlier = {
                name: left.head[name] for name in ("start_time", "heights") if name in left.head
            }
            self._head = (
                {
                    "format": FORMAT,
                    "format_version": FORMAT_VERSION,
                    "ranks": comm.size,
                    "io": self._io_way(),
                    "signs": SIGNS,
                    "start_time": datetime.now(UTC).isoformat(timespec="seconds"),
                }
                | self.earlier
                | head
            )
            self._surface = dict(surface)
            self.update()
        except GfmdError:
            self.close()
            raise

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
        """Add attributes of the surface, root attributes, and the local slab of the heights, kept
        once for all load steps."""
        self._surface |= surface or {}
        self._head |= head
        heights = {} if height_field is None else {"surface/heights": height_field}
        self._fields |= self._write(self.partial / HEAD, "running", {}, heights)

    def write_step(
        self, index: int, attributes: dict, fields: dict[str, Any] | None = None
    ) -> None:
        """Write one finished load step: numbers and {name: local slab, shape (rows, n_y)} of the
        fields asked for.

        Raises GfmdError on every rank if it cannot be written; steps written before stay as they
        are.
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
        path, identity = self.partial / STATE, self._head["identity"]
        return on_rank_0(self.comm, f"reading {path}", lambda: read_checkpoint(path, identity))

    def take(self, result: Result) -> None:
        """Take all load steps of a result, numbered anew, which `finish` writes."""
        result = replace(result, indices=[*range(len(result.steps))])
        self.finished, self._fields = dict(enumerate(result.steps)), result.datasets

    def finish(self, status: str) -> None:
        """Compose OUT.h5 from the finished steps, put it in place of any older one and remove the
        folder.

        Raises GfmdError on every rank if that fails, or the fields of a step are damaged; the
        finished steps stay in the folder.
        """
        self._head["end_time"] = datetime.now(UTC).isoformat(timespec="seconds")
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
            if not keep or not (self.partial / HEAD).exists():
                clear(self.partial)
            os.close(self._lock)
            self._lock = None

    def __exit__(self, kind: type | None, *_: object) -> None:
        refused = kind is not None and issubclass(kind, SceneError)
        begun = bool(self.finished) or self.resumed
        self.close(keep=self._resume and (begun or not refused))  # a wrong scene leaves nothing

    def _claim(
        self, identity: str | None, resume: bool, force: bool
    ) -> tuple[Result, bool, list[str]]:
        """Make and lock the folder, on rank 0; returns what an earlier run left, whether this one
        goes on with it, and notes."""
        if not self.path.parent.is_dir():
            raise SceneError(f"output.path: the folder {self.path.parent} does not exist")
        if self.path.is_dir():
            raise SceneError(f"output.path: {self.path} is a folder, a file name is needed")
        try:
            self._lock = acquire(self.partial)
        except OSError as error:
            raise SceneError(
                f"output.path: cannot write to {error.filename}: {reason(error)}"
            ) from None
        left, loads = None, len(step_files(self.partial)) if (self.partial / HEAD).exists() else 0
        with suppress(SceneError):  # nothing, or nothing that can be read
            left = read_partial(self.path)
        same = left is not None and left.head.get("identity") == identity
        if left is not None and same and resume and not force:
            there = f"{len(left.steps)} finished loads are there"
            return left, True, [*left.notes, f"going on with an interrupted run: {there}"]
        whose = (
            "that cannot be read" if left is None else f"of {'this' if same else 'another'} scene"
        )
        if loads and not force:
            raise SceneError(
                f"output.path: {self.partial} holds {loads} finished loads {whose}, allowed:"
                " another path, or --force to remove them"
            )
        notes = [self._replaced(identity, force)] if self.path.exists() else []
        if left is not None or loads:
            notes.append(f"removed an interrupted run {whose} ({loads} finished loads)")
        clear(self.partial, keep_lock=True)
        return Result(None, {}, [], [], "running", {}, []), False, notes

    def _replaced(self, identity: str | None, force: bool) -> str:
        """Say what file will be replaced; raises SceneError if it may not be."""
        try:
            same = read_result(self.path).head.get("identity") == identity
            what = (
                "holds a result of this scene, which this run replaces"
                if same
                else "holds the result of another scene"
            )
        except SceneError as error:
            same, what = False, f"exists and is no result that can be read ({error})"
        if not (same or force):
            raise SceneError(
                f"output.path: {self.path} {what}, allowed: another path, or --force to"
                " overwrite it"
            )
        return f"{self.path} {what}" + ("" if same else ": overwritten")

    def _write(
        self, path: Path, status: str, steps: dict[str, dict], fields: dict[str, Any]
    ) -> dict[str, Stored]:
        head = self._head | {"status": status}
        return write_file(
            self.comm,
            path,
            *self._points,
            fields,
            lambda file: describe(file, head, self._surface, steps, self._about),
            **self._how,
        )
