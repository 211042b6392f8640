"""`hpc-gfmd export`: a result for other programs."""

from argparse import ArgumentParser, Namespace
from typing import Any

from ..contact import all_numbers
from ..output.export import FORMATS, export
from ..output.read import read_result


def add_parser(subparsers: Any) -> ArgumentParser:
    parser = subparsers.add_parser(
        "export",
        help="a result for other programs",
        description=(
            "Write a result for ParaView (vtkhdf), as netCDF-4, as NumPy arrays (npz), its numbers"
            " as a table (csv), its fields for Gwyddion (gwy), or one length of one load as X3P."
            " ParaView and xarray also open the result itself."
        ),
    )
    parser.add_argument("file", metavar="OUT.h5", help="result file")
    parser.add_argument("--to", required=True, choices=FORMATS, help="what to write")
    parser.add_argument("-o", "--output", metavar="FILE", help="where (default: beside the result)")
    parser.add_argument("--fields", nargs="+", metavar="NAME", help="these alone (default: all)")
    parser.add_argument(
        "--step", nargs="+", type=int, metavar="K", help="these load steps alone (default: all)"
    )
    return parser


def main(args: Namespace) -> int:
    """Write the export and print its name; raises SceneError if the result cannot be read or the
    file cannot go there."""
    result = read_result(args.file).only(args.step, args.fields)
    print(export(result, args.to, args.output, all_numbers()))
    print(*result.remarks, sep="\n", end="\n" * bool(result.remarks))
    return 0
