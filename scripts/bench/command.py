"""The command line of the measurements."""

import tomllib
from importlib import import_module
from pathlib import Path

from hpc_gfmd.commands.cli import Parser
from hpc_gfmd.util.errors import SceneError

ITEMS = tomllib.loads(Path(__file__).with_name("items.toml").read_text())


def make_parser():
    """Make the parser of all measurements."""
    parser = Parser(
        prog="bench",
        description="Measure speed: alternating, warmed up. Compare numbers of one call only.",
    )
    parser.set_defaults(main=main)
    items = parser.add_subparsers(metavar="ITEM", required=True, parser_class=Parser)
    for item, options in ITEMS.items():
        text = options["help"]
        part = items.add_parser(item, help=text, description=text)
        for name, default in options.items():
            if name == "help":
                continue
            several = isinstance(default, list)
            part.add_argument(
                f"--{name}",
                default=default,
                type=type(default[0] if several else default),
                nargs="*" if several else None,
                help=f"default {default}",
            )
        part.add_argument("-o", "--out", metavar="DIR", help="write tables, rows and pictures here")
        part.set_defaults(item=item)
    return parser


def main(args):
    """Measure one item: run(args) of the file of that name. Raises SceneError for arguments that
    make no sense."""
    from hpc_gfmd.parallel.world import world

    if not args.n or min(args.n) < 8 or any(n % 4 for n in args.n):
        raise SceneError(f"--n: found {args.n}, allowed: multiples of 4 from 8")
    if args.repeats < 1:
        raise SceneError(f"--repeats: found {args.repeats}, allowed: a whole number from 1")
    if args.item != "storage" and world().size > 1:
        raise SceneError(f"bench {args.item}: found {world().size} ranks, allowed: one")
    import_module(f".{args.item}", __package__).run(args)
    return 0
