"""What a measurement leaves behind: a text table for readers, and one JSON line per row for
programs, which says where it was made."""

import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path

from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.fftw import fft_library
from hpc_gfmd.util.versions import processor, versions


class Report:
    """Collects rows, prints them as they come and writes NAME.jsonl and NAME.txt; only rank 0 does.

    append: to the rows that are there.
    """

    def __init__(self, name, out, comm=None, append=False):
        comm = comm or SerialComm()
        self.head = {"bench": name} | provenance(comm)
        self.rows = []
        self.notes = ["# " + ", ".join(f"{key} {value}" for key, value in self.head.items())]
        self.speaks, self.path = comm.rank == 0, Path(out) / f"{name}.jsonl" if out else None
        if self.path and self.speaks:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.path.open("a" if append else "w").close()
            self.rows = [json.loads(line) for line in self.path.read_text().splitlines()]

    def note(self, line):
        """Say something that is no row."""
        self.notes.append(f"# {line}")
        if self.speaks:
            print(self.notes[-1], flush=True)

    def add(self, **row):
        """Add one row of results: to the screen and, at once, to the file."""
        self.rows.append(row)
        if self.speaks:
            print("  ".join(f"{key} {_shown(value)}" for key, value in row.items()), flush=True)
            if self.path:
                with self.path.open("a") as file:
                    file.write(json.dumps(row | {"provenance": self.head}) + "\n")

    def finish(self):
        """Write the table."""
        if self.speaks and self.path:
            self.path.with_suffix(".txt").write_text("\n".join([*self.notes, *table(self.rows)]))
            print(f"written: {self.path}, .txt", file=sys.stderr)


def table(rows):
    """Return lines of what is a number or a word in the rows, in columns."""
    keys = dict.fromkeys(
        key for row in rows for key in row if not isinstance(row[key], dict | list)
    )
    cells = [list(keys)] + [[_shown(row.get(key, "-")) for key in keys] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    return ["  ".join(f"{c:>{w}}" for c, w in zip(line, widths)) for line in cells]


def _shown(value):
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def provenance(comm):
    """Return host, processor, load, versions, commit, time, and the ranks of this process."""
    git = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty=+"]
    said = subprocess.run(git, capture_output=True, text=True, check=False)
    return {
        "host": platform.node(),
        "cpu": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load_average": os.getloadavg()[0],
        "ranks": comm.size,
        "time": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "commit": said.stdout.strip(),
        "versions": versions() | {"FFT": fft_library()},
    }
