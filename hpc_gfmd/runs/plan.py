"""Forecast of the memory, files and time of a scene, without running it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..driver.precision_forecast import first_of_scene, precisions
from ..surface import cell_of
from ..util.machine import GIB
from .memory import memory_of

if TYPE_CHECKING:
    from ..scene import Scene
    from ..surface import Size

# For the order of magnitude of the time, from scripts/bench: FFT pairs of a load to an accuracy of
# 1e-3, and for each further decade; factor where the pressure is searched for.
PAIRS = 8.0
PAIRS_PER_DECADE = 3.0
SEARCHING = 1.5
PAIRS_OF_GFMD = 150.0
# seconds of a pair, for each point of the grid and byte of a number, on one core
SECONDS = 5e-9
START = "        and start-up: some seconds; up to half a minute of compiling at the first run"


def plan_of(
    scene: Scene, size: Size, ranks: int, per_node: int, threads: int, cores: int
) -> dict[str, Any]:
    """Return the forecast that `hpc-gfmd plan --json` prints: GiB, and seconds on this machine."""
    n = size.n
    cell = cell_of(n, scene.surface.free, size.lengths)
    first_dtype = first_of_scene(scene)
    dtypes = precisions(scene, n)  # None: unknown before the run
    itemsize = 8 if np.float64 in dtypes else first_dtype.itemsize
    busy_cores = min(ranks * threads, cores)
    plan: dict[str, Any] = {
        "n": list(n),
        "points": n[0] * n[1],
        "cell": list(cell),
        "loads": len(dtypes),
        "precision": [dtype.name if dtype else "unknown" for dtype in dtypes],
        "ranks": ranks,
        "ranks_per_node": per_node,
        "threads": threads,
        "notes": scene.warnings(),
        "idle_ranks": max(0, ranks - cell[0]),
        "points_per_rank": -(-cell[0] // ranks) * cell[1],
        **_memory(scene, size, itemsize, ranks, per_node, threads),
        **_files(scene, n, cell, itemsize),
        "seconds": _seconds(scene, cell, precisions(scene, n, first_dtype)) / busy_cores,
    }
    if any(dtype is None for dtype in dtypes):
        in_double = _memory(scene, size, 8, ranks, per_node, threads)
        plan["gib_per_rank_in_double"] = in_double["gib_per_rank"]
        plan["gib_in_double"] = in_double["gib"]
        seconds = _seconds(scene, cell, precisions(scene, n, np.float64))
        plan["seconds_in_double"] = seconds / busy_cores
    return plan


def _memory(
    scene: Scene, size: Size, itemsize: int, ranks: int, per_node: int, threads: int
) -> dict[str, Any]:
    """Return the memory of a rank, of a node and of all ranks by name."""
    gib_per_rank = memory_of(scene, size, itemsize, ranks, threads)
    return {
        "bytes_per_rank": round(gib_per_rank * GIB),
        "gib_per_rank": gib_per_rank,
        "gib_per_node": per_node * gib_per_rank,
        "gib": ranks * gib_per_rank,
    }


def _files(
    scene: Scene, n: tuple[int, int], cell: tuple[int, int], itemsize: int
) -> dict[str, float]:
    """Return the sizes of the result file and of the checkpoint of an interrupted load, in GiB."""
    stored = {"single": 4, "double": 8, None: itemsize}[scene.output.dtype]
    _, loads = scene.load.prescribed
    numbers = len(loads) * len(scene.output.fields) * n[0] * n[1]
    return {
        "file_gib": numbers * stored / GIB,
        "checkpoint_gib": cell[0] * cell[1] * itemsize / GIB,
    }


def _seconds(scene: Scene, cell: tuple[int, int], dtypes: list[np.dtype | None]) -> float:
    """Return the order of magnitude of the time of all loads on one core."""
    decades = -np.log10(scene.solver.tolerance) - 3
    pairs = PAIRS_OF_GFMD if scene.solver.name == "gfmd" else PAIRS
    pairs *= max(0.6, 1 + decades * PAIRS_PER_DECADE / PAIRS)
    pairs *= SEARCHING if scene.load.is_searched else 1.0
    nbytes = sum(dtype.itemsize for dtype in dtypes if dtype is not None)
    return float(pairs * cell[0] * cell[1] * nbytes * SECONDS)


def text_of(plan: dict[str, Any]) -> str:
    """Return a plan, with "gib_available" of this machine, as the text that is printed."""
    n_x, n_y = plan["n"]
    cell_x, cell_y = plan["cell"]
    ranks = counted(plan["ranks"], "rank")
    grid = f", solved on {cell_x} x {cell_y}" if plan["cell"] != plan["n"] else ""
    lines = [
        f"{n_x} x {n_y} = {plan['points']:.4g} points{grid}, {counted(plan['loads'], 'load')},"
        f" {ranks} of up to {plan['points_per_rank']:.4g} points",
        f"memory: {plan['gib_per_rank']:.2f} GiB per rank, {plan['gib_per_node']:.2f} GiB per node"
        f" of {counted(plan['ranks_per_node'], 'rank')}, {plan['gib']:.2f} GiB in all;"
        f" {plan['gib_available']:.2f} GiB available on this machine",
    ]
    if "gib_in_double" in plan:
        lines.append(
            f"        {plan['gib_per_rank_in_double']:.2f} GiB per rank,"
            f" {plan['gib_in_double']:.2f} GiB in all if a load needs double precision: if few"
            " points touch, or rounding errors matter"
        )
    lines.append(
        f"files:  result {plan['file_gib']:.3g} GiB; an interrupted"
        f" load {plan['checkpoint_gib']:.3g} GiB"
    )
    in_double = ""
    if "seconds_in_double" in plan:
        in_double = f" ({duration(plan['seconds_in_double'])} in double precision)"
    lines += [
        f"time:   of the order of {duration(plan['seconds'])}{in_double} for the loads, with"
        f" {ranks} of {counted(plan['threads'], 'thread')} on this machine",
        START,
    ]
    if plan["idle_ranks"]:
        lines.append(f"idle:   {plan['idle_ranks']} ranks have no rows")
    lines += [f"note:   {note}" for note in plan["notes"]]
    return "\n".join(lines)


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, plural unless it is 1: "1 rank", "2 ranks"."""
    return f"{number} {noun}{'s' * (number != 1)}"


def duration(seconds: float) -> str:
    """Return seconds as text: two significant digits, no power of ten: 0.35 s, 110 s, 12000 s."""
    digits = 1 - int(np.floor(np.log10(max(seconds, 1e-3))))
    return f"{round(seconds, digits):.{max(digits, 0)}f} s"
