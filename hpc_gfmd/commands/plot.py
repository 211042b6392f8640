"""`hpc-gfmd plot`: the pictures of a result file."""

from ..errors import GfmdError
from ..output.read import read_result
from ..output.table import converged


def add_parser(subparsers):
    parser = subparsers.add_parser(
        "plot",
        help="pictures of a result",
        description="Draw contact maps and distributions (if the file has fields) and area and gap over "
        "load, with Persson's theory. Fields of any size are read piece by piece.",
    )
    parser.add_argument("file", metavar="OUT.h5", help="result file")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for them (default: beside the file)")
    parser.set_defaults(main=main, saves=True)
    return parser


def main(args) -> int:
    """Draw and print the names of the pictures; raises SceneError if the file or the folder is unusable."""
    result = read_result(args.file)
    try:
        from ..plotting import plot_result
    except ImportError as error:
        raise GfmdError(f"plot needs matplotlib and scipy ({error}): pip install matplotlib scipy") from None
    for path in plot_result(result, args.output):
        print(path)
    doubtful = [str(i) for i, step in zip(result.indices, result.steps, strict=True) if not converged(step)]
    if doubtful:
        print(f"! not converged: step {', '.join(doubtful)} (marked in the pictures)")
    for index, step in zip(result.indices, result.steps, strict=True):
        if step.get("note"):
            print(f"step {index}: {step['note']}")
    for note in result.notes:
        print(f"note: {note}")
    if result.folder is not None:
        print(f"! the run is {result.status}: only its finished load steps are shown")
    return 0
