"""The folder of a run before it begins: locked, and cleared of what is not to be gone on with."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ..util.errors import GfmdError, SceneError, reason
from ..util.file_names import require_name
from .folder import HEAD, acquire, clear, partial_folder, release, step_files
from .read import read_file, read_parts
from .result import Result


class EarlierRun(NamedTuple):
    """What an earlier run has left at the place of a result.

    Attributes
    ----------
    result : Result
        Its finished loads; without any where nothing is gone on with.
    is_resumed : bool
        Whether the new run goes on with it.
    notes : list of str
        What a user has to know, a line each.
    """

    result: Result
    is_resumed: bool
    notes: list[str]


def claim(path: Path, identity: str | None, resume: bool, force: bool) -> tuple[int, EarlierRun]:
    """Make and lock the folder for partial results of a run. Called on rank 0 only.

    Unless an earlier run is resumed, everything in that folder but the lock is removed.

    Parameters
    ----------
    path : Path
        The result file, OUT.h5.
    identity : str or None
        Of the scene; a run of the same identity can be resumed.
    resume : bool
        Whether to go on with an interrupted run.
    force : bool
        Whether to start over, discarding finished loads, and to overwrite any file at path.

    Returns
    -------
    int
        The open descriptor that holds the lock, for `folder.release`.
    EarlierRun
        What was there.

    Raises
    ------
    SceneError
        If the folder of OUT.h5 is missing or not writable, another run holds the lock, or,
        without force, finished loads or the result of another scene would be lost.
    """
    require_name("output.path", path)
    if not path.parent.is_dir():
        raise SceneError(f"output.path: the folder {path.parent} does not exist")
    if path.is_dir():
        raise SceneError(f"output.path: {path} is a folder, a file name is needed")
    folder = partial_folder(path)
    try:
        lock = acquire(folder)
    except OSError as error:
        raise SceneError(
            f"output.path: cannot write to {error.filename}: {reason(error)}"
        ) from None
    try:
        files = step_files(folder)
        return lock, _earlier_run(path, folder, files, identity, resume, force)
    except GfmdError:
        release(folder, lock)
        raise


def _earlier_run(
    path: Path,
    folder: Path,
    files: dict[int, Path],
    identity: str | None,
    resume: bool,
    force: bool,
) -> EarlierRun:
    """Return what is there; clear the folder unless the run goes on. Raises SceneError.

    files: of the finished loads, by their numbers.
    """
    has_begun = (folder / HEAD).exists()
    loads = len(files) if has_begun else 0
    interrupted: Result | None = None
    if has_begun:
        with suppress(SceneError):  # nothing can be read
            interrupted = read_parts(folder / HEAD, files)
    is_same = interrupted is not None and interrupted.head.get("identity") == identity
    if interrupted is not None and is_same and resume and not force:
        count = len(interrupted.steps)
        finished = "1 load is finished" if count == 1 else f"{count} loads are finished"
        note = f"resuming an interrupted run: {finished}"
        return EarlierRun(interrupted, True, [*interrupted.notes, note])
    whose = (
        "that cannot be read"
        if interrupted is None
        else f"of {'this' if is_same else 'another'} scene"
    )
    if loads and not force:
        raise SceneError(
            f"output.path: {folder} holds {loads} finished loads {whose}, allowed: another path, or"
            " --force to remove them"
        )
    notes = [_note_on_replaced(path, identity, force)] if path.exists() else []
    if interrupted is not None or loads:
        notes.append(f"removed an interrupted run {whose} ({loads} finished loads)")
    clear(folder, keep_lock=True)
    return EarlierRun(Result(None, {}, [], [], "running", {}, []), False, notes)


def _note_on_replaced(path: Path, identity: str | None, force: bool) -> str:
    """Return a note on the file that will be replaced. Raises SceneError if it may not be."""
    try:
        is_same = read_file(path).head.get("identity") == identity
    except SceneError as error:
        is_same = False
        content = f"exists and is no result that can be read ({error})"
    else:
        content = (
            "holds a result of this scene, which this run replaces"
            if is_same
            else "holds the result of another scene"
        )
    if not (is_same or force):
        raise SceneError(
            f"output.path: {path} {content}, allowed: another path, or --force to overwrite it"
        )
    return f"{path} {content}" if is_same else f"{path} {content}: overwritten"
