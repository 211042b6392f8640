"""The command line of the measurements."""

import tomllib
from importlib import import_module
from pathlib import Path

from hpc_gfmd.commands.cli import Parser
from hpc_gfmd.util.errors import SceneError

ITEMS = tomllib.loads(Path(__file__).with_name("items.toml").read_text())


def make_parser():
    """Return the parser of all measurements, with the options of items.toml."""
    parser = Parser(
        prog="bench",
        description="Measure speed: runs alternate after a warm-up. Compare only the numbers of"
        " one call.",
    )
    parser.set_defaults(main=main)
    subparsers = parser.add_subparsers(metavar="ITEM", required=True, parser_class=Parser)
    for item, options in ITEMS.items():
        text = options["help"]
        subparser = subparsers.add_parser(item, help=text, description=text)
        for name, default in options.items():
            if name == "help":
                continue
            is_list = isinstance(default, list)
            subparser.add_argument(
                f"--{name}",
                default=default,
                type=type(default[0] if is_list else default),
                nargs="*" if is_list else None,
                help=f"default {default}",
            )
        subparser.add_argument(
            "-o", "--out", metavar="DIR", help="write tables, rows and pictures to this folder"
        )
        subparser.set_defaults(item=item)
    return parser


def main(args):
    """Call run(args) in the file of args.item. Raises SceneError for arguments out of range."""
    from hpc_gfmd.parallel.world import world

    if not args.n or min(args.n) < 8 or any(n % 4 for n in args.n):
        raise SceneError(f"--n: found {args.n}, allowed: multiples of 4 from 8")
    if args.repeats < 1:
        raise SceneError(f"--repeats: found {args.repeats}, allowed: a whole number from 1")
    if args.item != "storage" and world().size > 1:
        raise SceneError(f"bench {args.item}: found {world().size} ranks, allowed: one")
    import_module(f".{args.item}", __package__).run(args)
    return 0
