"""`hpc-gfmd run`: solve a scene."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from .common import add_file, add_overrides, add_quiet

HELP = "solve a scene"
DESCRIPTION = """
Solve a scene and write its result file, on one process or under mpirun/srun. Exit code 3: a load
did not converge."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_file(parser, "scene", metavar="SCENE.toml", help="scene file")
    add_file(
        parser,
        "-o",
        "--output",
        metavar="OUT.h5",
        help="result file, instead of output.path of the scene",
    )
    add_overrides(parser, "change a setting of the scene: table.key=value")
    parser.add_argument(
        "--force",
        action="store_true",
        help="start anew: overwrite an interrupted run or the result of another scene",
    )
    parser.add_argument(
        "--plot", action="store_true", help="draw the result, too, in the folder OUT_plots"
    )
    parser.add_argument(
        "--halve-steps",
        action="store_true",
        help="solve a history (load.time) once more with half its time steps, and print what that"
        " changes",
    )
    add_quiet(parser)


def main(args: Namespace) -> int:
    """Solve a scene and write its result; returns 3 if a load did not converge. Collective."""
    from ..parallel.guard import on_rank_0
    from ..parallel.world import world
    from ..runs.halved import changes_by_halving, require_steps, text_of
    from ..runs.simulation import run_scene
    from ..scene import load_scene

    scene = on_rank_0(world(), "reading the scene", lambda: load_scene(args.scene, args.set))
    if args.halve_steps:
        require_steps(scene)
    result = run_scene(scene, out=args.output, force=args.force, quiet=args.quiet)
    is_finished = result.exit_code in (0, 3)
    if args.plot and is_finished and result.path is not None and world().rank == 0:
        _plot(result.path)
    if args.halve_steps and is_finished:
        text = text_of(changes_by_halving(scene, result.steps, world()))
        if world().rank == 0:
            print(text)
    return result.exit_code


def _plot(path: Path) -> None:
    from ..output.read import read_result
    from .plot import save_pictures

    pictures = path.with_name(f"{path.stem}_plots")
    save_pictures([read_result(path)], pictures)
    print(f"result:   {path}")
    print(f"pictures: {pictures}")
