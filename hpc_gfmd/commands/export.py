"""`hpc-gfmd export`: a result for other programs."""

from argparse import Namespace

from ..contact import all_numbers
from ..output.export import export
from ..output.read import read_result


def main(args: Namespace) -> int:
    """Write the export and print its name; raises SceneError if the result cannot be read or the
    file cannot go there."""
    result = read_result(args.file).only(args.step, args.fields)
    print(export(result, args.to, args.output, all_numbers()), *result.remarks, sep="\n")
    return 0
