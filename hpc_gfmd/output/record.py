"""The result file while it is being written.

Everything finished goes at once into the folder OUT.h5.partial, one file per load step, and at the end all of
it becomes OUT.h5 in one rename. So nothing finished is lost, and nothing half-written has a final name.
"""

import os
import re
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from ..errors import GfmdError, SceneError
from ..parallel.guard import guarded, one_line
from ..parallel.h5 import Slab, write_file
from . import lock
from .read import HEAD, Result, partial_folder, read_partial

_OURS = re.compile(r"(head|step-\d+|checkpoint[\w-]*)\.h5(\.tmp)?|wisdom-\w+")


class RunFile:
    """The result file of one run. All methods are collective.

    comm: the ranks; path: OUT.h5; n: (n_x, n_y); rows: (start, stop) of this rank, may be empty;
    head: root attributes, among them `scene` (TOML text), `identity` (of the scene), `versions`;
    surface: attributes; resume: keep the finished steps of an interrupted run of the same identity, otherwise
    they are removed; compressed: shuffle and gzip; dtype: of the stored fields, such as "single" (default: as
    they come); transport: see hpc_gfmd.parallel.h5.

    finished: indices of the steps that are already there; note: one line about what was found, or ""; earlier: root attributes of the
    run that is resumed which hold for this one, too.
    Raises SceneError if the folder is missing or not writable, another run holds the file, or resume finds
    another scene.
    """

    def __init__(self, comm, path, n, rows, head, surface, *,
                 resume=False, compressed=False, dtype=None, transport=None):
        self.comm = comm
        self.path = Path(path)
        self.partial = partial_folder(self.path)
        self.n = (int(n[0]), int(n[1]))
        self.rows = (int(rows[0]), int(rows[1]))
        self.dtype = dtype
        self.compressed = compressed
        self.transport = transport
        self._lock = None
        self._resume = resume
        found = None
        try:
            with guarded(comm, f"opening {self.path}"):
                if comm.rank == 0:
                    found = self._claim(head.get("identity"), resume)
            self.finished, self.note, self.earlier = comm.bcast(found)
            self._head = {"start_time": _now(), "ranks": comm.size} | self.earlier | head
            self._surface = dict(surface)
            self._write_head("running")
        except GfmdError:
            self.close()
            raise

    @property
    def checkpoint(self) -> Path:
        """Where the state of the solver is kept."""
        return self.partial / "checkpoint.h5"

    def update_head(self, **attributes) -> None:
        """Add or change root attributes, for example setup_seconds."""
        self._head |= attributes
        self._write_head("running")

    def update_surface(self, **attributes) -> None:
        """Add or change attributes of the surface."""
        self._surface |= attributes
        self._write_head("running")

    def write_step(self, index: int, attributes: dict, fields: dict[str, np.ndarray] | None = None) -> None:
        """One finished load step: numbers and the local slabs, shape (rows, n_y), of the fields asked for.

        Raises GfmdError on every rank if it cannot be written; steps written before stay as they are.
        """
        slabs = {name: Slab(data, self.rows[0], self.n, self.dtype) for name, data in (fields or {}).items()}
        target = self.partial / f"step-{index:04d}.h5"
        self._write(target, {"/": attributes}, slabs, compressed=self.compressed)
        self.finished = sorted({*self.finished, index})

    def finish(self, status: str, **attributes) -> None:
        """Compose OUT.h5 from the finished steps, put it in place of any older one and remove the folder.

        Raises GfmdError on every rank if that fails; the finished steps stay in the folder.
        """
        self._head |= {"end_time": _now()} | attributes
        done = None
        with guarded(self.comm, f"reading {self.partial}"):
            if self.comm.rank == 0:
                done = read_partial(self.path)
                lost = [str(index) for index in self.finished if index not in done.indices]
                if lost:
                    raise GfmdError(f"the files of load steps {', '.join(lost)} have been damaged; restart to solve them again")
        groups, fields, copies = self._compose(self.comm.bcast(done), status)
        try:
            self._write(self.path, groups, fields, copies=copies)
        except GfmdError as error:
            raise GfmdError(f"{error}; the finished steps are safe in {self.partial}") from error
        with guarded(self.comm, f"removing {self.partial}"):
            if self.comm.rank == 0:
                (self.partial / HEAD).unlink()
            self.close()

    def close(self) -> None:
        """Give the file back without finishing it: what is there can be resumed."""
        if self._lock is not None:
            if not (self.partial / HEAD).exists():  # finished, or never begun
                _clear(self.partial)
            os.close(self._lock)
            self._lock = None

    def __enter__(self) -> "RunFile":
        return self

    def __exit__(self, kind, *_) -> None:
        refused = kind is not None and issubclass(kind, SceneError)
        if refused and self._lock is not None and not self.finished and not self._resume:
            (self.partial / HEAD).unlink(missing_ok=True)  # a wrong scene leaves nothing behind
        self.close()

    @property
    def _tmp(self) -> Path:
        return self.path.with_name(self.path.name + ".tmp")

    def _claim(self, identity, resume) -> tuple[list[int], str, dict]:
        """Rank 0: folder, lock, and what an earlier run left."""
        if not self.path.parent.is_dir():
            raise SceneError(f"output.path: the folder {self.path.parent} does not exist")
        if self.path.is_dir():
            raise SceneError(f"output.path: {self.path} is a folder, a file name is needed")
        try:
            self.partial.mkdir(exist_ok=True)
            self._lock = lock.acquire(self.partial)
        except OSError as error:
            raise SceneError(f"output.path: cannot write to {self.path.parent}: {one_line(error)}") from None
        try:
            left = read_partial(self.path)
        except SceneError:
            left = None  # nothing, or died before its head was complete
        if left is not None and resume:
            if left.head.get("identity") != identity:
                raise SceneError(f"{self.partial}: belongs to another scene; remove it or change output.path")
            for junk in (*self.partial.glob("*.tmp"), self._tmp):
                junk.unlink(missing_ok=True)
            states = zip(left.indices, [step.get("status") for step in left.steps], strict=True)
            done = [index for index, status in states if status != "interrupted"]
            kept = {name: left.head[name] for name in ("start_time", "heights") if name in left.head}
            return done, f"resuming: {len(done)} finished load steps found in {self.partial}", kept
        note = ""
        if left is not None:
            kind = "the same" if left.head.get("identity") == identity else "another"
            note = f"removed an interrupted run of {kind} scene ({len(left.steps)} finished load steps)"
        _clear(self.partial, keep_lock=True)
        self._tmp.unlink(missing_ok=True)
        return [], note, {}

    def _write_head(self, status) -> None:
        groups = {"/": self._head | {"status": status}, "surface": self._surface}
        self._write(self.partial / HEAD, groups, {})

    def _write(self, path, groups, fields, **how) -> None:
        write_file(self.comm, path, groups, fields, transport=self.transport, **how)

    def _compose(self, done: Result, status) -> tuple[dict, dict, dict]:
        groups = {"/": self._head | {"status": status}, "surface": self._surface, "steps": {}}
        fields, copies = {}, {}
        for index, step, stored in zip(done.indices, done.steps, done.fields, strict=True):
            groups[f"steps/{index:04d}"] = step
            for name, item in stored.items():
                target = copies if item.compressed else fields
                target[f"steps/{index:04d}/{name}"] = replace(item, span=self.rows)
        return groups, fields, copies


def tidy(path) -> None:
    """Remove what a run that died after it had finished `path` left beside it. One process only."""
    folder = partial_folder(path)
    if Path(path).exists() and folder.is_dir() and not (folder / HEAD).exists() and not lock.is_held(folder):
        _clear(folder)


def _clear(folder: Path, keep_lock=False) -> None:
    """Remove what is ours, the head first: a folder without a head is nobody's run."""
    names = [p.name for p in folder.iterdir() if _OURS.fullmatch(p.name)] if folder.is_dir() else []
    for name in sorted(names, key=lambda name: not name.startswith("head")):
        (folder / name).unlink(missing_ok=True)
    if not keep_lock:
        (folder / lock.NAME).unlink(missing_ok=True)
        with suppress(OSError):  # somebody else may keep something there
            folder.rmdir()


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
