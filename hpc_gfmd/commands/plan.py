"""`hpc-gfmd plan`: what a scene would take, without allocating it."""

import json
import os
from argparse import ArgumentParser, Namespace
from typing import Any

from ..util.errors import SceneError


def add_parser(subparsers: Any) -> ArgumentParser:
    parser = subparsers.add_parser(
        "plan",
        help="grid, memory per rank, expected time of a scene",
        description=(
            "Say what a scene takes on a number of ranks of this machine. Exit code 2 if it does"
            " not fit."
        ),
    )
    parser.add_argument("scene", metavar="SCENE.toml")
    parser.add_argument(
        "--ranks",
        type=int,
        default=1,
        metavar="K",
        help="number of ranks (default 1), as many as you like",
    )
    parser.add_argument(
        "--threads", type=int, metavar="T", help="threads of each rank instead of machine.threads"
    )
    parser.add_argument(
        "--ranks-per-node",
        type=int,
        metavar="P",
        help=(
            "ranks on each node, which share memory (default: what Slurm says, else what this"
            " machine's cores take)"
        ),
    )
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="change the scene: table.key=value",
    )
    parser.add_argument("--json", action="store_true")
    return parser


def main(args: Namespace) -> int:
    """Print the plan; raises SceneError if the scene is wrong or does not fit into this machine."""
    from ..parallel.world import ranks_per_node
    from ..runs.composition import check
    from ..runs.decomposition import busiest
    from ..runs.memory import GIB, available_gib, largest_precision, memory_of
    from ..runs.timing import expected_seconds
    from ..scene import load_scene
    from ..surface import cell_of, surface_size

    for name in ("ranks", "threads", "ranks_per_node"):
        if getattr(args, name) is not None and getattr(args, name) < 1:
            raise SceneError(
                f"--{name.replace('_', '-')}: found {getattr(args, name)}, allowed: a whole number"
                " from 1"
            )
    scene = load_scene(args.scene, args.set)
    check(scene)
    n, sizes = surface_size(scene.surface)
    cell = cell_of(n, scene.surface.free, sizes)
    cores = len(os.sched_getaffinity(0))
    threads = args.threads or (
        max(1, cores // args.ranks) if scene.machine.threads == "auto" else scene.machine.threads
    )
    per_node = min(args.ranks, args.ranks_per_node or ranks_per_node(args.ranks, threads))
    memory = memory_of(scene, n, sizes, args.ranks, threads, per_node=per_node)
    there = scene.machine.memory_gib or available_gib()
    columns = cell[1] // 2 + 1
    shares = busiest(
        cell,
        largest_precision(scene, n),
        args.ranks,
        per_node,
        nominal=n,
        nested=scene.solver.nested is not False,
    )
    sent = [share.traffic for share in shares]
    plan = {
        "n": list(n),
        "points": n[0] * n[1],
        "cell": list(cell),
        "loads": len(scene.load.given[1]),
        "ranks": args.ranks,
        "ranks_per_node": per_node,
        "threads": threads,
        "idle_ranks": max(0, args.ranks - cell[0]),
        "idle_ranks_of_columns": max(0, args.ranks - columns),
        "points_per_rank": max(share.points for share in shares),
        "coarse_points_per_rank": max(share.coarse_points for share in shares),
        "columns_per_rank": max(int(share.layout.columns_held.max()) for share in shares),
        "padding": shares[0].padding,
        "bytes_per_rank": round(memory.total * GIB),
        "message_bytes_per_pair": max(nbytes for nbytes, _ in sent),
        "messages_per_pair": max(messages for _, messages in sent),
        "gib_per_rank": memory.total,
        "gib": memory.on_all(args.ranks),
        "gib_available": there,
        "fields_gib": memory.fields + memory.heights,
        "transforms_gib": memory.transforms,
        "certificate_gib": memory.certificate,
        "process_gib": memory.process,
        "file_gib": _file_gib(scene, n),
        "notes": scene.warnings(),
        "seconds": expected_seconds(scene, cell, args.ranks, cores),
    }
    if args.json:
        print(json.dumps(plan, indent=1))
    else:
        on = f", solved on {cell[0]} x {cell[1]}" if cell != tuple(n) else ""
        print(
            f"{n[0]} x {n[1]} = {plan['points']:.4g} points{on}, {plan['loads']} loads,"
            f" {args.ranks} ranks"
        )
        print(
            f"memory: {memory.total:.2f} GiB per rank, {plan['gib']:.2f} GiB in all, {there:.2f}"
            " GiB available"
        )
        print(
            f"        of it fields {plan['fields_gib']:.2f}, transforms {memory.transforms:.2f}, "
            f"certificate {memory.certificate:.2f}, process {memory.process:.2f}"
        )
        if plan["file_gib"]:
            print(f"file:   {plan['file_gib']:.3g} GiB, while it is written twice that")
        if args.ranks > 1:
            print(
                f"nodes:  {-(-args.ranks // per_node)} with {per_node} ranks each, which share"
                " memory (--ranks-per-node)"
            )
            print(
                f"ranks:  up to {plan['points_per_rank']:.4g} points each and"
                f" {plan['coarse_points_per_rank']:.4g} of coarser grids;"
                f" {plan['message_bytes_per_pair'] / 2**20:.3g} MiB in {plan['messages_per_pair']}"
                " messages per FFT pair"
            )
        print(f"time:   about {plan['seconds']:.2g} s of solving on this machine")
        if plan["idle_ranks"] or plan["idle_ranks_of_columns"]:
            print(
                f"idle:   {plan['idle_ranks']} ranks have no rows, {plan['idle_ranks_of_columns']}"
                " no columns of the spectrum"
            )
        for line in plan["notes"]:
            print(f"note:   {line}")
    # Nodes on which more ranks run than there are cores here are other machines: one rank has to
    # fit into one like this.
    here = per_node if per_node * threads <= cores or scene.machine.memory_gib else 1
    need = plan["gib"] if here == args.ranks else here * memory.total
    if need > there:
        raise SceneError(
            f"surface: {n[0]} x {n[1]} points need {need:.2f} GiB on {here} of {args.ranks} ranks,"
            f" this machine has {there:.2f} GiB: use more machines, fewer points or single"
            " precision"
        )
    return 0


def _file_gib(scene: Any, n: tuple[int, int]) -> float:
    """Of the fields, before compression."""
    from ..driver.precision import first_precision

    itemsize = {"single": 4, "double": 8, None: first_precision(scene.solver).itemsize}[
        scene.output.dtype
    ]
    return len(scene.load.given[1]) * len(scene.output.fields) * n[0] * n[1] * itemsize / 2**30
