"""`hpc-gfmd export`: a result for other programs."""

from argparse import ArgumentParser, Namespace

from .common import add_file, add_result_file

HELP = "a result for other programs"
DESCRIPTION = """
Convert a result for ParaView (vtkhdf), to netCDF-4, to NumPy arrays (npz), its numbers to a table
(csv), its fields for Gwyddion (gwy), or a field of lengths of one load to X3P. ParaView and xarray
also open the result file itself."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_result_file(parser)
    parser.add_argument(
        "--to",
        required=True,
        choices=["vtkhdf", "netcdf", "npz", "csv", "gwy", "x3p"],
        help="format",
    )
    add_file(
        parser, "-o", "--output", metavar="FILE", help="where to write (default: beside the result)"
    )
    parser.add_argument(
        "--fields", metavar="NAME", nargs="+", help="fields to export (default: all)"
    )
    parser.add_argument(
        "--step", metavar="K", nargs="+", type=int, help="load steps to export (default: all)"
    )


def main(args: Namespace) -> int:
    """Convert a result to the file of another program and print its name; returns 0.

    Raises SceneError if the result cannot be read, if the format cannot hold it or if there is no
    folder for the file, and GfmdError if writing fails.
    """
    from ..contact import all_numbers
    from ..output.export import export
    from ..output.read import read_result

    result = read_result(args.file).only(args.step, args.fields)
    path = export(result, args.to, args.output, all_numbers())
    print(path, *result.remarks, sep="\n")
    return 0
