"""What a benchmark leaves behind: a text table for readers, and one JSON line per row for programs,
which says where it was made."""

import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Collection, Iterable
from os import PathLike
from pathlib import Path
from typing import Any

from hpc_gfmd.parallel.comm import Comm
from hpc_gfmd.util.errors import SceneError
from hpc_gfmd.util.versions import processor, versions

Columns = dict[str, tuple[str, str]]


class Report:
    """Collects rows, says them as they come, and writes NAME.jsonl and NAME.txt. Only rank 0 says
    and writes.

    columns: {key of a row: (heading, format)} of the text table.
    """

    def __init__(
        self,
        name: str,
        columns: Columns,
        out: str | PathLike | None = None,
        comm: Comm | None = None,
    ):
        self.name, self.columns, self.comm = name, columns, comm
        self.speaker = comm is None or comm.rank == 0
        self.rows: list[dict[str, Any]] = []
        self.lines: list[str] = []
        self.provenance = provenance(comm)
        self.folder = Path(out) if out else None
        if self.folder and self.speaker:
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / f"{name}.jsonl").write_text("")
        where = self.provenance
        ranks = (
            f", {comm.size} ranks" if comm else ""
        )  # others tell the ranks and threads of what they start in their rows
        self.say(
            f"# {name}: {where['cpu']}{ranks}, load average {where['load_average']},"
            f" {where['time']}, commit {where['commit']}"
        )
        self.say(
            "  ".join(f"{heading:>{_width(heading, form)}}" for heading, form in columns.values())
        )

    def say(self, line: str) -> None:
        """One line of text."""
        if self.speaker:
            self.lines.append(line)
            print(line, flush=True)

    def add(self, **row: Any) -> None:
        """One row of results: to the screen and, at once, to the file."""
        self.rows.append(row)
        self.say(
            "  ".join(
                _cell(row.get(key), heading, form) for key, (heading, form) in self.columns.items()
            )
        )
        if self.folder and self.speaker:
            with open(self.folder / f"{self.name}.jsonl", "a") as file:
                file.write(
                    json.dumps({"bench": self.name} | row | {"provenance": self.provenance}) + "\n"
                )

    def finish(self) -> None:
        """Write the text; says where."""
        if self.folder and self.speaker:
            (self.folder / f"{self.name}.txt").write_text("\n".join(self.lines) + "\n")
            print(f"written: {self.folder / self.name}.jsonl, .txt", file=sys.stderr)


def provenance(comm: Comm | None = None) -> dict[str, Any]:
    """Host, processor, load, versions, commit, time, and threads and ranks of this process: those
    that it starts may have others."""
    return {
        "host": platform.node(),
        "cpu": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load_average": round(os.getloadavg()[0], 2),
        "ranks": comm.size if comm else 1,
        "threads": 1,
        "time": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "commit": _commit(),
        "versions": versions(),
    }


def _commit() -> str | None:
    """The commit of the source tree that runs, with a + if it was changed since; None outside of
    one."""
    here = Path(__file__).resolve().parents[2]
    if not (here / ".git").exists():
        return None
    git = ["git", "-C", str(here)]
    try:
        commit = subprocess.run(
            [*git, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
        ).stdout.strip()
        changed = subprocess.run(
            [*git, "status", "--porcelain", "--", "hpc_gfmd"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        return None
    return commit + ("+" if changed.strip() else "")


def one_of(key: str, found: Iterable[str], allowed: Collection[str]) -> None:
    """Raise SceneError for a name that is not among the allowed ones."""
    for name in found:
        if name not in allowed:
            raise SceneError(f"{key}: found {name!r}, allowed: {', '.join(allowed)}")


def _width(heading: str, form: str) -> int:
    digits = "".join(c for c in form.split(".")[0] if c.isdigit())
    return max(len(heading), int(digits or 0))


def _cell(value: Any, heading: str, form: str) -> str:
    width = _width(heading, form)
    text = (
        "-"
        if value is None
        else (str(value) if isinstance(value, str | bool) else f"{value:{form}}")
    )
    return f"{text:>{width}}"
