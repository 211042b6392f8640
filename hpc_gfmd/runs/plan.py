"""What a scene takes: memory, messages, files and time, without allocating it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..driver.precision import first_precision, precisions
from ..surface import cell_of
from ..util.machine import GIB
from .decomposition import busiest
from .memory import NEEDS, memory_of
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
    """Work out what a scene takes, by name."""
    cell = cell_of(n, scene.surface.free, sizes)
    first, known = first_precision(scene.solver), precisions(scene, n)
    decided = np.dtype(np.float64) if np.float64 in known else first
    shares = busiest(
        cell, decided, ranks, per_node, nominal=n, nested=scene.solver.nested is not False
    )
    nbytes, messages = np.max([share.traffic for share in shares], axis=0).tolist()
    memory = memory_of(scene, n, sizes, ranks, threads, per_node=per_node)
    pairs, busy = expected_pairs(scene), min(ranks, cores)
    alone = expected_seconds(pairs, precisions(scene, n, first), cell)
    fields = len(scene.output.fields) * n[0] * n[1] / GIB
    written = {"single": 4, "double": 8, None: decided.itemsize}[scene.output.dtype]
    plan = {
        "n": list(n),
        "points": n[0] * n[1],
        "cell": list(cell),
        "loads": len(known),
        "precision": [dtype.name if dtype else "unknown" for dtype in known],
        "ranks": ranks,
        "ranks_per_node": per_node,
        "threads": threads,
        "idle_ranks": max(0, ranks - cell[0]),
        "idle_ranks_of_columns": max(0, ranks - (cell[1] // 2 + 1)),
        "points_per_rank": max(share.points for share in shares),
        "coarse_points_per_rank": max(share.coarse_points for share in shares),
        "columns_per_rank": max(int(share.layout.columns_held.max()) for share in shares),
        "padding": shares[0].padding,
        "bytes_per_rank": round(memory.total * GIB),
        "message_bytes_per_pair": nbytes,
        "messages_per_pair": messages,
        "gib_per_rank": memory.total,
        "gib_per_node": memory.on_all(ranks) if per_node == ranks else per_node * memory.total,
        "gib": memory.on_all(ranks),
        "fields_gib": memory.fields + memory.heights,
        "transforms_gib": memory.transforms,
        "certificate_gib": memory.certificate,
        "process_gib": memory.process,
        "file_gib": len(known) * fields * written,
        "checkpoint_gib": (NEEDS.fields + NEEDS.step) * cell[0] * cell[1] * decided.itemsize / GIB,
        "notes": scene.warnings(),
        "seconds": alone / busy,
        "seconds_on_nodes": Cluster().seconds(alone, pairs * len(known), (nbytes, messages), ranks),
    }
    if any(dtype is None for dtype in known):
        double = np.float64
        other = memory_of(scene, n, sizes, ranks, threads, per_node=per_node, unknown=double)
        plan["gib_per_rank_in_double"], plan["gib_in_double"] = other.total, other.on_all(ranks)
        seconds = expected_seconds(pairs, precisions(scene, n, double), cell)
        plan["seconds_in_double"] = seconds / busy
    return plan


def text_of(plan: dict[str, Any]) -> str:
    """Write the plan as it is printed."""
    (n_x, n_y), ranks, per_node = plan["n"], plan["ranks"], plan["ranks_per_node"]
    on = f", solved on {plan['cell'][0]} x {plan['cell'][1]}" if plan["cell"] != plan["n"] else ""
    lines = [
        f"{n_x} x {n_y} = {plan['points']:.4g} points{on}, {counted(plan['loads'], 'load')},"
        f" {counted(ranks, 'rank')}",
        f"memory: {plan['gib_per_rank']:.2f} GiB per rank, {plan['gib_per_node']:.2f} GiB per node"
        f" of {counted(per_node, 'rank')}, {plan['gib']:.2f} GiB in all;"
        f" {plan['gib_available']:.2f} GiB available on this machine",
        f"        of a rank's fields {plan['fields_gib']:.2f}, transforms"
        f" {plan['transforms_gib']:.2f}, certificate {plan['certificate_gib']:.2f}, process"
        f" {plan['process_gib']:.2f}",
    ]
    if "gib_in_double" in plan:
        lines.append(
            f"        {plan['gib_per_rank_in_double']:.2f} GiB per rank,"
            f" {plan['gib_in_double']:.2f} GiB in all if a load needs double precision: few"
            " points that touch, or rounding errors that count"
        )
    lines.append(
        f"files:  result {plan['file_gib']:.3g} GiB, while it is written twice that; a checkpoint"
        f" {plan['checkpoint_gib']:.3g} GiB"
    )
    if ranks > 1:
        lines.append(
            f"ranks:  up to {plan['points_per_rank']:.4g} points each and"
            f" {plan['coarse_points_per_rank']:.4g} of coarser grids;"
            f" {plan['message_bytes_per_pair'] / 2**20:.3g} MiB in {plan['messages_per_pair']}"
            f" messages per FFT pair, {per_node} ranks of a node share memory (--ranks-per-node)"
        )
    in_double = (
        f" ({duration(plan['seconds_in_double'])} in double precision)"
        if "seconds_in_double" in plan
        else ""
    )
    lines.append(
        f"time:   about {duration(plan['seconds'])}{in_double} of solving with"
        f" {counted(ranks, 'rank')} on this machine; on nodes of {Cluster.cores} cores, by a model,"
        f" {duration(plan['seconds_on_nodes'])}"
    )
    if plan["idle_ranks"] or plan["idle_ranks_of_columns"]:
        lines.append(
            f"idle:   {plan['idle_ranks']} ranks have no rows, {plan['idle_ranks_of_columns']}"
            " no columns of the spectrum"
        )
    return "\n".join(lines + [f"note:   {line}" for line in plan["notes"]])


def counted(number: int, what: str) -> str:
    """Write a number of things: 1 rank, 2 ranks."""
    return f"{number} {what}{'s' * (number != 1)}"


def duration(seconds: float) -> str:
    """Write two digits, and no power of ten where a person reads it: 0.35 s, 110 s, 12000 s."""
    digits = 1 - int(np.floor(np.log10(max(seconds, 1e-3))))
    return f"{round(seconds, digits):.{max(digits, 0)}f} s"
