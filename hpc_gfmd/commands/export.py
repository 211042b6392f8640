"""`hpc-gfmd export`: a result for other programs."""

from ..output.export import FORMATS, export
from ..output.read import read_result


def add_parser(subparsers):
    parser = subparsers.add_parser(
        "export",
        help="a result for other programs",
        description="Write a result for ParaView (vtkhdf), as netCDF-4, as NumPy arrays (npz), or its numbers as a table (csv). "
        "ParaView and xarray also open the result itself.",
    )
    parser.add_argument("file", metavar="OUT.h5", help="result file")
    parser.add_argument("--to", required=True, choices=FORMATS, help="what to write")
    parser.add_argument("-o", "--output", metavar="FILE", help="where (default: beside the result)")
    parser.set_defaults(main=main)
    return parser


def main(args) -> int:
    """Write it and print its name; raises SceneError if the result cannot be read or the file cannot go there."""
    result = read_result(args.file)
    print(export(result, args.to, args.output))
    for note in result.notes:
        print(f"note: {note}")
    if result.folder is not None:
        print(f"! the run is {result.status}: only its finished load steps are exported")
    return 0
