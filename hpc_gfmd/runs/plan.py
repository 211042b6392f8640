"""Estimates of the memory, messages, files and time of a scene, without running it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..driver.precision import first_precision, precisions
from ..surface import cell_of
from ..util.machine import GIB
from .decomposition import busiest
from .memory import memory_of
from .timing import Cluster, expected_pairs, expected_seconds

if TYPE_CHECKING:
    from ..scene import Scene


def plan_of(
    scene: Scene,
    n: tuple[int, int],
    sizes: tuple[float, ...],
    ranks: int,
    per_node: int,
    threads: int,
    cores: int,
) -> dict[str, Any]:
    """Estimate memory, messages, files and time of a scene.

    The speed of this machine is measured for a few seconds unless it is in the user's cache.

    Parameters
    ----------
    scene : Scene
        What is to be solved.
    n : (int, int)
        Points along each axis of the surface.
    sizes : (float, float)
        Lengths of the surface.
    ranks, per_node, threads : int
        Number of ranks, of ranks on each node, and of threads of each rank.
    cores : int
        Cores of this machine, for the time.

    Returns
    -------
    dict
        Numbers by the names that `hpc-gfmd plan --json` prints; memory in GiB, times in seconds.
    """
    cell = cell_of(n, scene.surface.free, sizes)
    cell_sizes = tuple(size * m / k for size, m, k in zip(sizes, cell, n))
    dtype_at_first = first_precision(scene.solver)
    dtypes = precisions(scene, n)  # None: unknown before the run
    dtype = np.dtype(np.float64) if np.float64 in dtypes else dtype_at_first
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
    }
    plan |= _decomposition(scene, n, cell, cell_sizes, dtype, ranks, per_node)
    plan |= _memory(scene, cell, dtype.itemsize, ranks, per_node, threads)
    plan |= _files(scene, n, cell, dtype.itemsize)
    pairs = expected_pairs(scene)
    seconds = expected_seconds(pairs, precisions(scene, n, dtype_at_first), cell)  # on one core
    busy_cores = min(ranks, cores)
    traffic = plan["message_bytes_per_pair"], plan["messages_per_pair"]
    plan["seconds"] = seconds / busy_cores
    plan["seconds_on_nodes"] = Cluster().seconds(seconds, pairs * len(dtypes), traffic, ranks)
    if any(dtype is None for dtype in dtypes):
        in_double = _memory(scene, cell, 8, ranks, per_node, threads)
        plan["gib_per_rank_in_double"] = in_double["gib_per_rank"]
        plan["gib_in_double"] = in_double["gib"]
        seconds = expected_seconds(pairs, precisions(scene, n, np.float64), cell)
        plan["seconds_in_double"] = seconds / busy_cores
    return plan


def _decomposition(
    scene: Scene,
    n: tuple[int, int],
    cell: tuple[int, int],
    cell_sizes: tuple[float, ...],
    dtype: np.dtype,
    ranks: int,
    per_node: int,
) -> dict[str, Any]:
    """Return the decomposition by name: numbers of idle ranks, points, columns and messages.

    Points, columns and messages are each those of the rank that has most of them.
    """
    nested = scene.solver.nested is not False
    shares = busiest(cell, dtype, ranks, per_node, nominal=n, sizes=cell_sizes, nested=nested)
    nbytes, messages = np.max([share.traffic for share in shares], axis=0).tolist()
    return {
        "idle_ranks": max(0, ranks - cell[0]),
        "idle_ranks_of_columns": max(0, ranks - (cell[1] // 2 + 1)),
        "points_per_rank": max(share.points for share in shares),
        "coarse_points_per_rank": max(share.coarse_points for share in shares),
        "columns_per_rank": max(int(share.layout.columns_held.max()) for share in shares),
        "padding": shares[0].padding,
        "message_bytes_per_pair": nbytes,
        "messages_per_pair": messages,
    }


def _memory(
    scene: Scene, cell: tuple[int, int], itemsize: int, ranks: int, per_node: int, threads: int
) -> dict[str, Any]:
    """Return the memory of a rank, of a node and of all ranks by name."""
    gib_per_rank = memory_of(scene, cell, itemsize, ranks, threads)
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


def text_of(plan: dict[str, Any]) -> str:
    """Return a plan as the text that `hpc-gfmd plan` prints.

    The plan must have "gib_available" (of this machine), too, which `plan_of` does not set.
    """
    n_x, n_y = plan["n"]
    cell_x, cell_y = plan["cell"]
    ranks = counted(plan["ranks"], "rank")
    grid = f", solved on {cell_x} x {cell_y}" if plan["cell"] != plan["n"] else ""
    lines = [
        f"{n_x} x {n_y} = {plan['points']:.4g} points{grid}, {counted(plan['loads'], 'load')},"
        f" {ranks}",
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
    if plan["ranks"] > 1:
        lines.append(
            f"ranks:  up to {plan['points_per_rank']:.4g} points each and"
            f" {plan['coarse_points_per_rank']:.4g} of coarser grids;"
            f" {plan['message_bytes_per_pair'] / 2**20:.3g} MiB in {plan['messages_per_pair']}"
            f" messages per FFT pair; the {plan['ranks_per_node']} ranks of a node share memory"
            " (--ranks-per-node)"
        )
    in_double = ""
    if "seconds_in_double" in plan:
        in_double = f" ({duration(plan['seconds_in_double'])} in double precision)"
    lines.append(
        f"time:   about {duration(plan['seconds'])}{in_double} for the solves with {ranks} on this"
        f" machine; by a model, {duration(plan['seconds_on_nodes'])} on nodes of {Cluster.cores}"
        " cores"
    )
    lines.append(
        "        and start-up: some seconds; up to half a minute of compiling at the first run"
    )
    if plan["idle_ranks"] or plan["idle_ranks_of_columns"]:
        lines.append(
            f"idle:   {plan['idle_ranks']} ranks have no rows, {plan['idle_ranks_of_columns']}"
            " no columns of the spectrum"
        )
    lines += [f"note:   {note}" for note in plan["notes"]]
    return "\n".join(lines)


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, plural unless it is 1.

    Parameters
    ----------
    number : int
        How many.
    noun : str
        The singular.

    Returns
    -------
    str
        "1 rank", "2 ranks".
    """
    return f"{number} {noun}{'s' * (number != 1)}"


def duration(seconds: float) -> str:
    """Return seconds as text: two significant digits, no power of ten: 0.35 s, 110 s, 12000 s."""
    digits = 1 - int(np.floor(np.log10(max(seconds, 1e-3))))
    return f"{round(seconds, digits):.{max(digits, 0)}f} s"
