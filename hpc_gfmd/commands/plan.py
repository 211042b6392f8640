"""`hpc-gfmd plan`: what a scene would take, without allocating it."""

from argparse import ArgumentParser, Namespace

from ..util.errors import SceneError
from .common import add_file, add_json, add_overrides, as_json

HELP = "grid, memory per rank and expected time of a scene"
DESCRIPTION = """
Estimate memory, files and time of a scene on a number of ranks. Exit code 2 if it does not fit
into this machine."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_file(parser, "scene", metavar="SCENE.toml", help="scene file")
    parser.add_argument(
        "--ranks",
        metavar="K",
        type=int,
        help="number of ranks (default: as many as mpirun started)",
    )
    parser.add_argument(
        "--threads", metavar="T", type=int, help="threads per rank, instead of machine.threads"
    )
    parser.add_argument(
        "--ranks-per-node",
        metavar="P",
        type=int,
        help="ranks on each node, which share memory (default: from Slurm, else as many as this"
        " machine has cores for)",
    )
    add_overrides(parser, "change a setting of the scene: table.key=value")
    add_json(parser, "text")


def main(args: Namespace) -> int:
    """Print grid, memory and time of a scene; SceneError, afterwards, if it does not fit here."""
    from ..parallel.launcher import launched
    from ..parallel.thread_count import auto_threads, ranks_per_node
    from ..runs.loads import check
    from ..runs.memory import ADVICE
    from ..runs.plan import plan_of, text_of
    from ..scene import load_scene
    from ..surface import surface_size
    from ..util.machine import available_gib, cores

    for option in ("ranks", "threads", "ranks_per_node"):
        number = getattr(args, option)
        if number is not None and number < 1:
            raise SceneError(
                f"--{option.replace('_', '-')}: found {number}, allowed: a whole number from 1"
            )
    ranks = args.ranks or launched()[1] or 1
    scene = load_scene(args.scene, args.set)
    check(scene)
    size = surface_size(scene.surface)
    n_x, n_y = size.n
    core_count = len(cores())
    threads = args.threads or scene.machine.threads
    if threads == "auto":
        threads = auto_threads(n_x * n_y, ranks, core_count)
    per_node = min(ranks, args.ranks_per_node or ranks_per_node(ranks, threads))
    plan = plan_of(scene, size, ranks, per_node, threads, core_count)
    gib_available = scene.machine.memory_gib or available_gib()
    plan["gib_available"] = gib_available
    print(as_json(plan, 1) if args.json else text_of(plan))
    # More ranks on a node than this machine has cores: the nodes are other machines. One rank has
    # to fit into one like this.
    is_this_machine = per_node * threads <= core_count or scene.machine.memory_gib is not None
    ranks_here = per_node if is_this_machine else 1
    gib = plan["gib"] if ranks_here == ranks else ranks_here * plan["gib_per_rank"]
    if gib > gib_available:
        raise SceneError(
            f"surface: {n_x} x {n_y} points need {gib:.2f} GiB on {ranks_here} of {ranks}"
            f" ranks, this machine has {gib_available:.2f} GiB: {ADVICE}"
        )
    return 0
