"""`hpc-gfmd plan`: what a scene would take, without allocating it."""

from argparse import Namespace

from ..util.errors import SceneError
from .common import as_json


def main(args: Namespace) -> int:
    """Print the plan; raises SceneError if the scene is wrong or does not fit into this machine."""
    from ..parallel.world import auto_threads, ranks_per_node
    from ..runs.loads import check
    from ..runs.plan import plan_of, text_of
    from ..scene import load_scene
    from ..surface import surface_size
    from ..util.machine import available_gib, cores

    for name in ("ranks", "threads", "ranks_per_node"):
        if getattr(args, name) is not None and getattr(args, name) < 1:
            raise SceneError(
                f"--{name.replace('_', '-')}: found {getattr(args, name)}, allowed: a whole number"
                " from 1"
            )
    scene = load_scene(args.scene, args.set)
    check(scene)
    n, sizes = surface_size(scene.surface)
    here, said = len(cores()), args.threads or scene.machine.threads
    threads = auto_threads(n[0] * n[1], args.ranks, here) if said == "auto" else said
    per_node = min(args.ranks, args.ranks_per_node or ranks_per_node(args.ranks, threads))
    plan = plan_of(scene, n, sizes, args.ranks, per_node, threads, here)
    there = scene.machine.memory_gib or available_gib()
    plan["gib_available"] = there
    print(as_json(plan, 1) if args.json else text_of(plan))
    # Nodes on which more ranks run than there are cores here are other machines: one rank has to
    # fit into one like this.
    together = per_node if per_node * threads <= here or scene.machine.memory_gib else 1
    need = plan["gib"] if together == args.ranks else together * plan["gib_per_rank"]
    if need > there:
        raise SceneError(
            f"surface: {n[0]} x {n[1]} points need {need:.2f} GiB on {together} of {args.ranks}"
            f" ranks, this machine has {there:.2f} GiB: use more machines, fewer points or single"
            " precision"
        )
    return 0
