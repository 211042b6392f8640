"""`hpc-gfmd plot`: the pictures of a result file."""

from argparse import ArgumentParser, Namespace
from typing import Any

from ..output.read import read_result
from ..output.summary import converged
from ..util.errors import GfmdError, SceneError

WHAT = (
    "maps, distributions, spectra, curves; one field: contact, pressure, gap, heights,"
    " displacement; one curve: a_r, kappa, gap_mean, approach"
)


def add_parser(subparsers: Any) -> ArgumentParser:
    parser = subparsers.add_parser(
        "plot",
        help="pictures of a result",
        description=(
            "Draw what a result has: maps and distributions (output.fields), spectra"
            " (output.distributions), area and gap over the load. Axes have units where the scene"
            " has them. Persson's theory is drawn beside self-affine surfaces, Hertz' beside"
            " spheres, Westergaard's beside waves. Fields of any size are read piece by piece."
        ),
    )
    parser.add_argument("file", metavar="OUT.h5", help="result file")
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR|FILE",
        help=(
            "folder for them, or a file that ends in .png, .pdf or .svg "
            "(default: beside the result)"
        ),
    )
    parser.add_argument(
        "--what",
        nargs="+",
        metavar="NAME",
        help=f"which pictures: {WHAT} (default: the first four)",
    )
    parser.add_argument(
        "--step",
        nargs="+",
        type=int,
        metavar="K",
        help="load steps by their numbers (default: at most four, evenly)",
    )
    parser.add_argument(
        "--window",
        nargs=4,
        metavar=("X0", "X1", "Y0", "Y1"),
        help='part of the cell that maps show, plain in the unit of its sizes or as "2um"',
    )
    parser.add_argument("--dpi", type=int, help="dots per inch of maps and of .png (default: 300)")
    parser.add_argument(
        "--dimensionless",
        action="store_true",
        help="p/(E* g_rms) and gap/h_rms though the scene has units",
    )
    parser.set_defaults(saves=True)
    return parser


def main(args: Namespace) -> int:
    """Draw the pictures and print their names; raises SceneError if the file, the folder or what is
    asked for is unusable."""
    result = read_result(args.file)
    if args.dpi is not None and not 20 <= args.dpi <= 2400:
        raise SceneError(f"--dpi: found {args.dpi}, allowed: 20 to 2400")
    try:
        from ..plotting import chosen_steps, plot_result
    except ImportError as error:
        raise GfmdError(
            f"plot needs matplotlib and scipy ({error}): pip install matplotlib scipy"
        ) from None
    paths = plot_result(
        result,
        args.output,
        args.what,
        step=args.step,
        window=args.window,
        dpi=args.dpi,
        dimensionless=args.dimensionless,
    )
    print(*paths, sep="\n")
    said, names = [], args.what or ["maps"]
    shown = {result.indices[k] for k in chosen_steps(result, names[0], args.step)}
    left = [index for index in result.indices if index not in shown]
    if left and shown and names != ["heights"]:
        said.append(f"shown: step {_list(sorted(shown))}; left out: {_list(left)} (--step chooses)")
    steps = result.numbered
    if doubtful := [index for index, step in steps.items() if not converged(step)]:
        said.append(f"! not converged: step {_list(doubtful)} (marked in the pictures)")
    said += [f"step {index}: {step['note']}" for index, step in steps.items() if step.get("note")]
    for line in said + result.remarks:
        print(line)
    return 0


def _list(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers))
