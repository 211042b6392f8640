"""Where and with what a measurement was made: part of every row of results."""

import os
import platform
import subprocess
import time
from pathlib import Path
from typing import Any

from ..parallel.comm import Comm
from ..versions import processor, versions


def provenance(comm: Comm | None = None, threads: int = 1) -> dict[str, Any]:
    """Host, processor, load, versions, commit, time, threads and ranks."""
    return {"host": platform.node(), "cpu": processor(), "cores": len(os.sched_getaffinity(0)),
            "load_average": round(os.getloadavg()[0], 2),
            "ranks": comm.size if comm else 1, "threads": threads, "time": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            "commit": _commit(), "versions": versions()}


def _commit() -> str | None:
    """The commit of the source tree that runs, with a + if it was changed since; None outside of one."""
    here = Path(__file__).resolve().parents[2]
    if not (here / ".git").exists():
        return None
    git = ["git", "-C", str(here)]
    try:
        commit = subprocess.run([*git, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True).stdout.strip()
        changed = subprocess.run([*git, "status", "--porcelain", "--", "hpc_gfmd"], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return None
    return commit + ("+" if changed.strip() else "")
