"""The result file while it is written.

It grows in the folder OUT.h5.partial: each finished load is added and committed at once
(parallel/committed.py), and each field is written once. At the end it gets what other programs need
and is renamed to OUT.h5. The folder also holds the gap of a load that was stopped.
"""

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import DTypeLike

from ..parallel.comm import Comm
from ..parallel.committed import commit, recover
from ..parallel.grid import Grid
from ..parallel.guard import on_rank_0
from ..parallel.h5 import SLACK, lay_out, mpi_io_obstacle, write_file, write_rows
from ..util.atomic import sync
from ..util.errors import GfmdError, SceneError
from .claim import EarlierRun, claim
from .describe import SIGNS, describe, set_attributes
from .folder import GROWING, followed, partial_folder, release
from .numbers import About
from .read import CHECKPOINT, FORMAT, MEMORY, read_state
from .result import FORMAT_VERSION, Result, group_of

HEIGHTS = "surface/heights"
STATES = {CHECKPOINT: "checkpoint.h5", MEMORY: "memory-{:04d}.h5"}  # by the number of a load


class RunFile(AbstractContextManager):
    """The result file of one run, for a `with` statement. All methods are collective.

    Creating it locks the folder, and may empty it (`claim.claim`). What is finished stays, unless
    `resume` is False or the scene was refused before a load. `rows`: of this rank; `head`: scene,
    identity, versions; `finished`: numbers of loads; `earlier`: head of a resumed run.
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
        compressed: bool = False,
        dtype: str | None = None,
    ):
        self.comm = comm
        self.path = followed(path)
        self.partial = partial_folder(path)
        self.growing = self.partial / GROWING
        self._n = (int(n[0]), int(n[1]))
        self._rows = rows
        self._compressed = compressed
        self._dtype = dtype
        self._together = False
        self._begun = False
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
        """Write the head, after which the run can be resumed. Raises GfmdError on every rank."""
        import h5py

        try:
            if not self.resumed:
                self._add({})
            obstacle = mpi_io_obstacle(self.comm, self.growing)
            self._together = not obstacle and not self._compressed
            self._head = {"io": "serial" if obstacle else "mpio", **self._head}
            self._add({})
        except GfmdError:
            self.close()
            raise
        if obstacle and self.comm.size > 1 and h5py.get_config().mpi:
            note = f"{self.path}: rank 0 writes for all, because MPI-IO cannot ({obstacle})"
            self.notes = [*self.notes, note]
        return self

    def update(self, surface: dict | None = None, height_field: Any = None, **head: Any) -> None:
        """Add attributes and this rank's rows of the heights to the head of the result."""
        self._surface |= surface or {}
        self._head |= head
        self._add({}, {} if height_field is None else {HEIGHTS: height_field})

    def require_space(self, loads: int, dtypes: Iterable[DTypeLike]) -> None:
        """Raise SceneError if the disk is too small for the fields of the next loads, of these
        types unless the scene gives another (packed: unknown).
        """
        points = self._n[0] * self._n[1]
        of_fields = (np.dtype(self._dtype or dtype).itemsize for dtype in dtypes)
        needed = SLACK + points * sum(of_fields)

        def check() -> None:
            """Compare with the disk of the folder."""
            free = shutil.disk_usage(self.partial).free
            if needed > free and not self._compressed:
                raise SceneError(
                    f"output.fields: {needed / 1e6:.4g} MB are needed for {loads} loads, and"
                    f" {free / 1e6:.4g} MB are free at {self.path}: No space left on device"
                )

        on_rank_0(self.comm, f"writing {self.path}", check)

    def write_step(
        self, index: int, attributes: dict, fields: dict[str, Any] | None = None
    ) -> None:
        """Write a finished load, without numbers that are None, and add it to `finished`."""
        attributes = {name: value for name, value in attributes.items() if value is not None}
        group = group_of(index)
        slabs = {f"{group}/{key}": data for key, data in (fields or {}).items()}
        self._add({group: attributes}, slabs)
        self.finished = dict(sorted((self.finished | {index: attributes}).items()))

    def _state_path(self, kind: str, index: int) -> Path:
        return self.partial / STATES[kind].format(index)

    def write_state(
        self,
        kind: str,
        index: int,
        fields: dict[str, np.ndarray],
        numbers: dict,
        grid: Grid | None = None,
    ) -> None:
        """Write one of STATES; grid: of its fields, by default that of the result. A memory is
        written before its load is finished, and the one before stays until then.
        """
        name = group_of(index)
        n, rows = (grid.n, grid.rows) if grid else (self._n, self._rows)
        groups = {
            "/": {
                "format": kind,
                "format_version": FORMAT_VERSION,
                "identity": self._head["identity"],
            },
            "surface": {"n": list(n)},
            name: numbers,
        }
        write_file(
            self.comm,
            self._state_path(kind, index),
            n,
            rows,
            {f"{name}/{key}": field for key, field in fields.items()},
            lambda file: set_attributes(file, groups),
            self._together,
        )

    def state(self, kind: str, index: int) -> Result | None:
        """Read what `write_state` has written, as `read_state`."""
        path = self._state_path(kind, index)
        identity = self._head["identity"]
        return on_rank_0(self.comm, f"reading {path}", lambda: read_state(path, kind, identity))

    def forget_state(self, kind: str, index: int) -> None:
        """Remove what `write_state` has written for a load, if anything."""
        path = self._state_path(kind, index)
        on_rank_0(self.comm, f"removing {path}", lambda: path.unlink(missing_ok=True))

    def take(self, result: Result) -> None:
        """Write all loads of a result, numbered from 0, with their fields; heights, which all
        share, once.
        """
        heights = [fields["heights"] for fields in result.fields if "heights" in fields]
        self.update(height_field=heights[0] if heights else None)
        for index, (step, fields) in enumerate(zip(result.steps, result.fields, strict=True)):
            of_step = {name: field for name, field in fields.items() if name != "heights"}
            self.write_step(index, step, of_step)

    def finish(self, status: str) -> None:
        """Complete the file, rename it to OUT.h5, remove the folder; on failure the steps stay."""
        self._head |= {"end_time": _now(), "status": status}
        steps = {group_of(index): step for index, step in self.finished.items()}

        def complete() -> None:
            """Add what other programs need, on rank 0."""
            with _recovering(self.growing):
                lay_out(
                    self.growing,
                    {},
                    lambda file: describe(file, self._head, self._surface, steps, self._about),
                    more=True,
                )
                sync(self.growing)
            self.growing.replace(self.path)
            sync(self.path.parent)
            self.close(keep=False)

        try:
            on_rank_0(self.comm, f"writing {self.path}", complete)
        except GfmdError as error:
            if not self._resume:
                raise
            raise GfmdError(f"{error}; the finished steps are safe in {self.partial}") from error

    def close(self, keep: bool = True) -> None:
        """Release the lock, once; the folder stays if `keep` is set and the run has begun."""
        if self._lock is not None:
            release(self.partial, self._lock, keep)
            self._lock = None

    def __exit__(self, kind: type | None, *_: object) -> None:
        """Release the lock; keep what is finished for a later run, see the class."""
        refused = kind is not None and issubclass(kind, SceneError)
        begun = bool(self.finished) or self.resumed
        self.close(keep=self._resume and (begun or not refused))  # a wrong scene leaves nothing

    def _add(self, steps: dict[str, dict], slabs: dict[str, Any] | None = None) -> None:
        """Add attributes of root, surface and steps, and local slabs by path, and commit; or leave
        the file as it was and raise GfmdError on all ranks.
        """
        slabs = slabs or {}
        doing = f"writing {self.path}"
        types = {name: np.dtype(self._dtype or slab.dtype) for name, slab in slabs.items()}
        head = self._head | {"status": "running"}
        groups = {"/": head, "surface": self._surface, **steps}
        is_new = not (self.resumed or self._begun)

        def prepare() -> None:
            """Make room for the slabs, on rank 0."""
            lay_out(
                self.growing,
                {name: (self._n, dtype) for name, dtype in types.items()},
                lambda file: set_attributes(file, groups),
                self._compressed,
                more=not is_new,
            )

        with _recovering(self.growing) if self.comm.rank == 0 else nullcontext():
            on_rank_0(self.comm, doing, prepare)
            if slabs:
                write_rows(
                    self.comm, self.growing, self._n, self._rows, slabs, self._together, doing
                )
            on_rank_0(self.comm, doing, lambda: commit(self.growing))
        self._begun = True


@contextmanager
def _recovering(path: Path) -> Iterator[None]:
    """Bring a file back to its committed state if the block fails, Ctrl-C included."""
    try:
        yield
    except BaseException:
        with suppress(OSError, ValueError):
            recover(path)
        raise


def _now() -> str:
    """Return the present time as text, UTC, ISO 8601, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")
