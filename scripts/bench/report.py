"""The results of a measurement: a text table for readers, and JSON lines for programs, each with
the machine and the versions with which it was measured."""

import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path

from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.fftw import load_fftw
from hpc_gfmd.util.versions import processor, versions


class Report:
    """Collects rows, prints them as they come and writes them to NAME.jsonl and NAME.txt.

    Only rank 0 prints and writes.

    Parameters
    ----------
    name : str
        Name of the measurement.
    out : str or None
        Folder of the files; None to write none.
    comm : SerialComm or MpiComm, optional
        Ranks that take part; this process by default.
    append : bool
        Whether to keep the rows of an existing file.

    Attributes
    ----------
    head : dict
        Provenance, which is stored with every row.
    rows : list of dict
        All rows, those of an existing file first.
    notes : list of str
        Lines above the table.
    path : Path or None
        Of NAME.jsonl.
    """

    def __init__(self, name, out, comm=None, append=False):
        comm = comm or SerialComm()
        self.head = {"bench": name} | provenance(comm)
        self.rows = []
        self.notes = ["# " + ", ".join(f"{key} {value}" for key, value in self.head.items())]
        self.path = Path(out) / f"{name}.jsonl" if out else None
        self._prints = comm.rank == 0
        if self.path and self._prints:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.path.open("a" if append else "w").close()
            self.rows = [json.loads(line) for line in self.path.read_text().splitlines()]

    def note(self, line):
        """Print a line and put it above the table."""
        self.notes.append(f"# {line}")
        if self._prints:
            print(self.notes[-1], flush=True)

    def add(self, **row):
        """Print a row and append it to the file at once."""
        self.rows.append(row)
        if self._prints:
            print("  ".join(f"{key} {_cell(value)}" for key, value in row.items()), flush=True)
            if self.path:
                with self.path.open("a") as file:
                    file.write(json.dumps(row | {"provenance": self.head}) + "\n")

    def finish(self):
        """Write the table."""
        if self._prints and self.path:
            self.path.with_suffix(".txt").write_text("\n".join([*self.notes, *table(self.rows)]))
            print(f"written: {self.path}, .txt", file=sys.stderr)


def table(rows):
    """Return the lines of a table in columns, without values that are dicts or lists."""
    keys = dict.fromkeys(
        key for row in rows for key in row if not isinstance(row[key], dict | list)
    )
    cells = [list(keys)] + [[_cell(row.get(key, "-")) for key in keys] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    return ["  ".join(f"{c:>{w}}" for c, w in zip(line, widths)) for line in cells]


def _cell(value):
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def provenance(comm):
    """Return host, processor, load, number of ranks, time, commit and versions."""
    git = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty=+"]
    described = subprocess.run(git, capture_output=True, text=True, check=False)
    return {
        "host": platform.node(),
        "cpu": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load_average": os.getloadavg()[0],
        "ranks": comm.size,
        "time": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        "commit": described.stdout.strip(),
        "versions": versions() | {"FFT": load_fftw()[0]},
    }
