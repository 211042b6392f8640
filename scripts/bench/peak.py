"""The peak memory of a process. peer_worker.py imports it, too, without the package around it."""

import resource
from pathlib import Path


def peak_mib():
    """Return the largest resident memory of this process so far in MiB.

    getrusage, which also counts the parent before exec, is used only where there is no /proc.
    """
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    kib = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    return int(kib.split()[1]) / 2**10
