"""Cores and memory of this machine, as its operating system reports them."""

import os
from pathlib import Path

GIB = 2**30


def cores() -> list[int]:
    """List the numbers of the CPU cores that this process may use, ascending."""
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def available_gib() -> float:
    """Return the memory that new processes can allocate: Linux's available one, or what control
    groups leave; infinity if unknown.
    """
    gib = [float("inf")]
    if available_kib := _table(Path("/proc/meminfo")).get("MemAvailable:"):
        gib.append(available_kib * 1024 / GIB)
    elif hasattr(os, "sysconf"):
        gib.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIB)
    for folder in control_groups():
        cached = _table(folder / "memory.stat").get("inactive_file", 0)  # freed when needed
        for limit_name, usage_name in (
            ("memory.max", "memory.current"),
            ("memory.limit_in_bytes", "memory.usage_in_bytes"),
        ):
            try:
                limit = int((folder / limit_name).read_text())
                usage = int((folder / usage_name).read_text())
                gib.append((limit - usage + cached) / GIB)
            except (OSError, ValueError):  # another version of control groups, or "max"
                pass
    return min(gib)


def control_groups(
    root: Path = Path("/sys/fs/cgroup"), membership: Path = Path("/proc/self/cgroup")
) -> list[Path]:
    """List the folders of this process's control groups, versions 1 and 2."""
    try:
        lines = [line.split(":", 2) for line in membership.read_text().splitlines()]
    except OSError:
        lines = []
    folders = [root]  # a container may report a path that only the host has
    for _, controllers, path in lines:
        if controllers == "" or "memory" in controllers.split(","):
            top = root / "memory" if controllers else root
            group = top / path.lstrip("/")
            folders += [group, *(outer for outer in group.parents if outer.is_relative_to(top))]
    return list(dict.fromkeys(folders))


def limit_gib() -> float:
    """Return the address space left to this process by `ulimit -v`; infinity without a limit."""
    try:
        import resource

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except (ImportError, OSError):
        return float("inf")
    free = limit - pages * resource.getpagesize()
    return float("inf") if limit == resource.RLIM_INFINITY else free / GIB


def _table(path: Path) -> dict[str, int]:
    """Read the lines "word number ..." of a file as {word: number}; empty if it cannot be read."""
    try:
        lines = [line.split() for line in path.read_text().splitlines()]
    except OSError:
        return {}
    return {words[0]: int(words[1]) for words in lines if len(words) > 1 and words[1].isdigit()}
