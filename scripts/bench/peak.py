"""The highest memory of a process. Also read by peer_worker.py, which has no package around it."""

import resource
from pathlib import Path


def peak_mib():
    """Return the highest resident memory of this process so far (MiB). What getrusage tells counts
    the process that started this one, too, and is taken where there is no /proc."""
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    kib = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    return int(kib.split()[1]) / 2**10
