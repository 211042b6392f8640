"""What has been solved: one JSON line per surface and load, appended when it is finished and never
changed."""

import json
import os
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

from .case import SURFACE, Case
from .rows import Rows

KEY = (*SURFACE, "p_star", "accuracy")
DIGITS = 9  # of a number in the key


class Store:
    """The lines of all runs*.jsonl in a folder. part: write runs-<part>.jsonl, so that several jobs
    can share the folder."""

    def __init__(self, folder: str | Path, part: int | None = None) -> None:
        self.folder = Path(folder)
        self.path = self.folder / ("runs.jsonl" if part is None else f"runs-{part}.jsonl")

    def load(self) -> Rows:
        """All runs as dicts, a run that was stored twice once, with the columns of both. A line not
        written to its end is left out."""
        found: dict[tuple, dict] = {}
        for path in sorted(self.folder.glob("runs*.jsonl")):
            for line in path.read_bytes().split(b"\n"):
                run = _parsed(line)
                if run is not None:
                    found[key_of(run)] = found.get(key_of(run), {}) | run
        return list(found.values())

    def runs_of(self, cases: list[Case]) -> Rows:
        """The stored runs that these cases ask for, with all that they ask for."""
        wanted = defaultdict(list)
        for case in cases:
            for key in _keys(case):
                wanted[key].append(case.columns)
        return [
            run
            for run in self.load()
            if any(columns <= set(run) for columns in wanted.get(key_of(run), ()))
        ]

    def append(self, run: dict) -> None:
        """Add one run; it is on the disk when this returns. Raises OSError."""
        self.folder.mkdir(parents=True, exist_ok=True)
        line = json.dumps(run, allow_nan=False).encode() + b"\n"
        file = os.open(self.path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            end = os.lseek(file, 0, os.SEEK_END)
            if end and os.pread(file, 1, end - 1) != b"\n":
                line = b"\n" + line  # a torn line stays alone
            if os.write(file, line) != len(line):
                raise OSError(f"{self.path}: the line was not written to its end")
            os.fsync(file)
        finally:
            os.close(file)


def key_of(run: dict) -> tuple[float, ...]:
    """What tells a run from others: the surface, the load and the accuracy."""
    return tuple(float(f"{run[name]:.{DIGITS}g}") for name in KEY)


def missing(case: Case, stored: dict) -> Case | None:
    """The case with those loads only that are not stored with all its columns; None if none is
    left. stored: {key: columns}."""
    left = tuple(
        p
        for p, key in zip(case.p_star, _keys(case), strict=True)
        if key not in stored or not case.columns <= stored[key]
    )
    return replace(case, p_star=left) if left else None


def _keys(case: Case) -> list[tuple[float, ...]]:
    surface = {name: getattr(case, name) for name in (*SURFACE, "accuracy")}
    return [key_of(surface | {"p_star": p}) for p in case.p_star]


def _parsed(line: bytes) -> dict | None:
    try:
        run = json.loads(line)
        key_of(run)
    except (ValueError, TypeError, KeyError):  # torn, or not a run
        return None
    return run
