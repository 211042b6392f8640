"""Start of a run in its folder: lock it, find what an earlier run left, remove what is stale."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ..parallel.committed import recover
from ..util.errors import GfmdError, SceneError, reason
from ..util.file_names import require_name
from .folder import GROWING, acquire, clear, has_begun, of_earlier_version, partial_folder, release
from .read import read_file
from .result import Result


class EarlierRun(NamedTuple):
    """What an earlier run has left where this run writes; no loads if nothing is resumed."""

    result: Result
    is_resumed: bool
    notes: list[str]


def claim(path: Path, identity: str | None, resume: bool, force: bool) -> tuple[int, EarlierRun]:
    """Create and lock the folder for partial results; return the lock and what was there. Rank 0
    only. A run of the same identity is resumed if `resume` and not `force`; SceneError if something
    would be lost.
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
        return lock, _earlier_run(path, folder, identity, resume, force)
    except GfmdError:
        release(folder, lock)
        raise


def _earlier_run(
    path: Path, folder: Path, identity: str | None, resume: bool, force: bool
) -> EarlierRun:
    """Return what an earlier run left in the locked folder; empty it unless that is resumed."""
    interrupted: Result | None = None
    whose = ""
    loads = of_earlier_version(folder)
    if loads:
        whose = f"{loads} finished loads of another version"
    elif has_begun(folder):
        try:
            interrupted = read_file(folder / GROWING)
        except SceneError:
            whose = "an interrupted run that cannot be read"
        else:
            loads = len(interrupted.steps)
            is_same = interrupted.head.get("identity") == identity
            if is_same and resume and not force:
                recover(folder / GROWING)
                finished = "1 load is finished" if loads == 1 else f"{loads} loads are finished"
                return EarlierRun(interrupted, True, [f"resuming an interrupted run: {finished}"])
            whose = f"{loads} finished loads of {'this' if is_same else 'another'} scene"
    if whose and (loads or interrupted is None) and not force:
        raise SceneError(
            f"output.path: {folder} holds {whose}, allowed: another path, or --force to remove them"
        )
    notes = [_note_on_replaced(path, identity, force)] if path.exists() else []
    if whose:
        notes.append(f"removed an interrupted run: {whose}")
    clear(folder, keep_lock=True)
    return EarlierRun(Result(None, {}, [], [], "running", {}, []), False, notes)


def _note_on_replaced(path: Path, identity: str | None, force: bool) -> str:
    """Return a note on the result file to be replaced; SceneError if it is of another scene,
    without `force`.
    """
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
