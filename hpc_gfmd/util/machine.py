"""What this machine has: cores and memory, as far as its system tells."""

import os
from pathlib import Path

GIB = 2**30


def cores() -> list[int]:
    """List the cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def available_gib() -> float:
    """Return the memory of this machine that new processes can get together, of their control group
    if that is less; infinite where nobody tells."""
    gib = [float("inf")]
    if found := _table(Path("/proc/meminfo")).get("MemAvailable:"):
        gib.append(found * 1024 / GIB)
    elif hasattr(os, "sysconf"):
        gib.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIB)
    for folder in control_groups():
        cached = _table(folder / "memory.stat").get("inactive_file", 0)  # given back when needed
        for limit, used in (
            ("memory.max", "memory.current"),
            ("memory.limit_in_bytes", "memory.usage_in_bytes"),
        ):
            try:
                most, taken = (int((folder / name).read_text()) for name in (limit, used))
                gib.append((most - taken + cached) / GIB)
            except (OSError, ValueError):  # another version of control groups, or "max"
                pass
    return min(gib)


def control_groups(
    root: Path = Path("/sys/fs/cgroup"), own: Path = Path("/proc/self/cgroup")
) -> list[Path]:
    """List the folders of the control groups that may limit the memory of this process: its own and
    all around it."""
    try:
        lines = [line.split(":", 2) for line in own.read_text().splitlines()]
    except OSError:
        lines = []
    found = [root]  # inside a container, where the path may be that outside
    for _, kinds, path in lines:
        if kinds == "" or "memory" in kinds.split(","):
            top = root / "memory" if kinds else root
            here = top / path.lstrip("/")
            found += [here, *(group for group in here.parents if group.is_relative_to(top))]
    return list(dict.fromkeys(found))


def limit_gib() -> float:
    """Return the memory that this process alone may still take (ulimit -v)."""
    try:
        import resource

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except (ImportError, OSError):
        return float("inf")
    free = limit - pages * resource.getpagesize()
    return float("inf") if limit == resource.RLIM_INFINITY else free / GIB


def _table(path: Path) -> dict[str, int]:
    """Return {first word: number that follows} of the lines of a file; empty without it."""
    try:
        lines = [line.split() for line in path.read_text().splitlines()]
    except OSError:
        return {}
    return {words[0]: int(words[1]) for words in lines if len(words) > 1 and words[1].isdigit()}
