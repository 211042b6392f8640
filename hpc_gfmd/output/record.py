"""The result file while it is being written.

Everything finished goes at once into the folder OUT.h5.partial, one file per load step, and at the end all of
it becomes OUT.h5 in one rename. So nothing finished is lost, and nothing half-written has a final name.
"""

import os
from contextlib import suppress
from datetime import UTC, datetime

from ..errors import GfmdError, SceneError
from ..parallel.guard import on_rank_0, one_line
from ..parallel.h5 import io_way, write_file
from .attributes import set_attributes
from .describe import SIGNS, describe
from .folder import HEAD, acquire, clear, followed, partial_folder, step_files
from .read import FORMAT, FORMAT_VERSION, fields_of, read_partial, read_whole, reading


class RunFile:
    """The result file of one run. All methods are collective.

    comm: the ranks; path: OUT.h5; n: (n_x, n_y); rows: (start, stop) of this rank, may be empty;
    head: root attributes, among them `scene` (TOML text), `identity` (of the scene), `versions`;
    surface: attributes; resume: keep the finished steps of an interrupted run of the same identity, otherwise
    they are removed; force: replace even what is no result of this scene; compressed: shuffle and gzip;
    dtype: of the stored fields, such as "single" (default: as they come).

    finished: indices of the steps that are already there; notes: what was found, a line each; earlier: root attributes of the
    run that is resumed which hold for this one, too.
    Raises SceneError if the folder is missing or not writable, another run holds the file, it is something else that may not be
    replaced, or resume finds another scene.
    """

    def __init__(self, comm, path, n, rows, head, surface, *, resume=False, force=False, compressed=False, dtype=None):
        self.comm, self.path, self.partial = comm, followed(path), partial_folder(path)
        self.n, self.rows = (int(n[0]), int(n[1])), (int(rows[0]), int(rows[1]))
        self.checkpoint = self.partial / "checkpoint.h5"  # where the state of the solver is kept
        self._how, self._resume, self._lock = {"compressed": compressed, "dtype": dtype}, resume, None
        try:
            found = on_rank_0(comm, f"opening {self.path}", lambda: self._claim(head.get("identity"), force))
            self.finished, self.notes, self.earlier = found
            self._head = {"format": FORMAT, "format_version": FORMAT_VERSION, "start_time": _now(), "ranks": comm.size,
                          "io": io_way(comm), "signs": SIGNS} | self.earlier | head
            self._surface = dict(surface)
            self.update()
        except GfmdError:
            self.close()
            raise

    def update(self, surface=None, height_field=None, **head) -> None:
        """Add attributes of the surface, root attributes, and the local slab of the heights, kept once for all load steps."""
        self._surface |= surface or {}
        self._head |= head
        self._write(self.partial / HEAD, "running", {}, {} if height_field is None else {"surface/heights": height_field})

    def write_step(self, index: int, attributes: dict, fields=None) -> None:
        """One finished load step: numbers and {name: local slab, shape (rows, n_y)} of the fields asked for.

        Raises GfmdError on every rank if it cannot be written; steps written before stay as they are.
        """
        name = f"steps/{index:04d}"
        slabs = {f"{name}/{key}": data for key, data in (fields or {}).items()}
        self._write(self.partial / f"step-{index:04d}.h5", "running", {name: attributes}, slabs)
        self.finished = sorted({*self.finished, index})

    def finish(self, status: str, **head) -> None:
        """Compose OUT.h5 from the finished steps, put it in place of any older one and remove the folder.

        Raises GfmdError on every rank if that fails; the finished steps stay in the folder.
        """
        self._head |= {"end_time": _now()} | head
        steps, fields = on_rank_0(self.comm, f"reading {self.partial}", self._collect)
        try:
            self._write(self.path, status, steps, fields)
        except GfmdError as error:
            raise GfmdError(f"{error}; the finished steps are safe in {self.partial}") from error
        on_rank_0(self.comm, f"removing {self.partial}", lambda: self.close(finished=True))

    def close(self, finished=False) -> None:
        """Give the file back; unless it is finished, what is there can be resumed."""
        if self._lock is not None:
            if finished:
                (self.partial / HEAD).unlink()
            if not (self.partial / HEAD).exists():  # otherwise never begun
                clear(self.partial)
            os.close(self._lock)
            self._lock = None

    def __enter__(self) -> "RunFile":
        return self

    def __exit__(self, kind, *_) -> None:
        refused = kind is not None and issubclass(kind, SceneError)
        if refused and self._lock is not None and not self.finished and not self._resume:
            (self.partial / HEAD).unlink(missing_ok=True)  # a wrong scene leaves nothing behind
        self.close()

    def _claim(self, identity, force) -> tuple[list[int], list[str], dict]:
        """Rank 0: folder, lock, and what an earlier run left."""
        if not self.path.parent.is_dir():
            raise SceneError(f"output.path: the folder {self.path.parent} does not exist")
        if self.path.is_dir():
            raise SceneError(f"output.path: {self.path} is a folder, a file name is needed")
        notes = [] if self._resume or not self.path.exists() else self._to_replace(identity, force)
        try:
            self._lock = acquire(self.partial)
        except OSError as error:
            raise SceneError(f"output.path: cannot write to {self.path.parent}: {one_line(error)}") from None
        left, files = None, step_files(self.partial) if (self.partial / HEAD).exists() else {}
        with suppress(SceneError):  # nothing, or nothing that can be read
            left = read_partial(self.path)
            notes += left.notes
        ours = left is not None and left.head.get("identity") == identity
        if self._resume and left is not None:
            if not ours:
                raise SceneError(f"{self.partial}: belongs to another scene; remove it or change output.path")
            kept = {name: left.head[name] for name in ("start_time", "heights") if name in left.head}
            return left.indices, [*notes, f"resuming: {len(left.steps)} finished load steps found in {self.partial}"], kept
        if left is not None or files:
            kind = "that cannot be read" if left is None else "of the same scene" if ours else "of another scene"
            notes += [f"removed an interrupted run {kind} ({len(files)} files of load steps)"]
        clear(self.partial, keep_lock=True)
        return [], notes, {}

    def _to_replace(self, identity, force) -> list[str]:
        """What is said of the file that will be replaced; raises SceneError if it may not be."""
        what = "holds the result of another scene"
        try:
            if read_whole(self.path).head.get("identity") == identity:
                return [f"{self.path} holds a result of this scene, which this run replaces"]
        except SceneError as error:
            what = f"exists and is no result that can be read ({error})"
        if not force:
            raise SceneError(f"output.path: {self.path} {what}, allowed: another path, or --force to overwrite it")
        return [f"{self.path} {what}: overwritten"]

    def _collect(self) -> tuple[dict, dict]:
        """Attributes and fields of all that is finished, by their names in the file. Raises GfmdError if something is missing."""
        done = read_partial(self.path)
        lost = [str(index) for index in self.finished if index not in done.indices]
        if lost:
            raise GfmdError(f"the files of load steps {', '.join(lost)} have been damaged; restart to solve them again")
        with reading(self.partial / HEAD) as file:
            heights = fields_of(self.partial / HEAD, file["surface"], self.n)
        fields = {field.dataset: field for group in (heights, *done.fields) for field in group.values()}
        return {f"steps/{index:04d}": step for index, step in zip(done.indices, done.steps, strict=True)}, fields

    def _write(self, path, status, steps, fields) -> None:
        def fill(file):
            for name, attributes in {"/": self._head | {"status": status}, "surface": self._surface, **steps}.items():
                set_attributes(file.require_group(name), attributes)
            describe(file)

        write_file(self.comm, path, self.n, self.rows, fields, fill, **self._how)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
