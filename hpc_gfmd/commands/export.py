"""`hpc-gfmd export`: a result for other programs."""

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path

from ..util.errors import SceneError
from .common import add_file, add_result_file

HELP = "a result for other programs"
DESCRIPTION = """
Write the numbers of a result as a table (csv), or its fields for Gwyddion (gwy). ParaView and
xarray open the result file itself."""


def known_format(name: str) -> str:
    """Return the name of a format; raises ArgumentTypeError if another way leads to it."""
    from ..output.export import INSTEAD

    if name in INSTEAD:
        raise ArgumentTypeError(f"{name}: {INSTEAD[name]}")
    return name


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_result_file(parser)
    parser.add_argument(
        "--to", required=True, type=known_format, choices=["csv", "gwy"], help="format"
    )
    add_file(
        parser, "-o", "--output", metavar="FILE", help="where to write (default: beside the result)"
    )
    parser.add_argument("--force", action="store_true", help="replace a file that exists")
    parser.add_argument(
        "--fields", metavar="NAME", nargs="+", help="fields to export (default: all)"
    )
    parser.add_argument(
        "--step", metavar="K", nargs="+", type=int, help="load steps to export (default: all)"
    )


def main(args: Namespace) -> int:
    """Convert a result to the file of another program and print its name; returns 0."""
    from ..contact import all_numbers
    from ..output.export import SUFFIXES, export
    from ..output.read import read_result

    result = read_result(args.file).only(args.step, args.fields)
    path = Path(args.output or Path(args.file).with_suffix(f".{args.to}"))
    if path.suffix.lower().removeprefix(".") in SUFFIXES - {args.to}:
        raise SceneError(f"-o: found {path} with --to {args.to}, allowed: a .{args.to} file")
    if path.is_file() and not args.force:
        raise SceneError(f"-o: found {path}, which exists, allowed: another path, or --force")
    export(result, args.to, path, all_numbers())
    print(path, *result.remarks, sep="\n")
    return 0
