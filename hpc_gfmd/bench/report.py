"""What a benchmark leaves behind: a text table for readers, and one JSON line per row for programs."""

import json
import sys
from pathlib import Path

from ..errors import SceneError
from .provenance import provenance


class Report:
    """Collects rows, says them as they come, and writes NAME.jsonl and NAME.txt. Only rank 0 says and writes.

    columns: {key of a row: (heading, format)} of the text table.
    """

    def __init__(self, name, columns, out=None, comm=None, threads=1):
        self.name, self.columns, self.comm = name, columns, comm
        self.speaker = comm is None or comm.rank == 0
        self.rows, self.lines = [], []
        self.provenance = provenance(comm, threads)
        self.folder = Path(out) if out else None
        if self.folder and self.speaker:
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / f"{name}.jsonl").write_text("")
        where = self.provenance
        self.say(f"# {name}: {where['cpu']}, {where['ranks']} ranks, {where['threads']} threads, load average {where['load_average']}, "
                 f"{where['time']}, commit {where['commit']}")
        self.say("  ".join(f"{heading:>{_width(heading, form)}}" for heading, form in columns.values()))

    def say(self, line):
        """One line of text."""
        if self.speaker:
            self.lines.append(line)
            print(line, flush=True)

    def add(self, **row):
        """One row of results: to the screen and, at once, to the file."""
        self.rows.append(row)
        self.say("  ".join(_cell(row.get(key), heading, form) for key, (heading, form) in self.columns.items()))
        if self.folder and self.speaker:
            with open(self.folder / f"{self.name}.jsonl", "a") as file:
                file.write(json.dumps({"bench": self.name} | row | {"provenance": self.provenance}) + "\n")

    def finish(self):
        """Write the text; says where."""
        if self.folder and self.speaker:
            (self.folder / f"{self.name}.txt").write_text("\n".join(self.lines) + "\n")
            print(f"written: {self.folder / self.name}.jsonl, .txt", file=sys.stderr)


def one_of(key, found, allowed):
    """Raise SceneError for a name that is not among the allowed ones."""
    for name in found:
        if name not in allowed:
            raise SceneError(f"{key}: found {name!r}, allowed: {', '.join(allowed)}")


def _width(heading, form):
    digits = "".join(c for c in form.split(".")[0] if c.isdigit())
    return max(len(heading), int(digits or 0))


def _cell(value, heading, form):
    width = _width(heading, form)
    text = "-" if value is None else (str(value) if isinstance(value, str | bool) else f"{value:{form}}")
    return f"{text:>{width}}"
