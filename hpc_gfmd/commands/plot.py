"""`hpc-gfmd plot`: the pictures of a result file."""

from argparse import ArgumentParser, Namespace
from typing import Any

from ..util.errors import SceneError
from .common import add_file

HELP = "pictures of a result"
DESCRIPTION = """
Draw the contents of a result: maps (of output.fields), spectra (of output.distributions),
distributions (of either), area and gap against load. Axes have units where the scene has them.
Persson's theory is drawn for self-affine surfaces, Hertz's for spheres, Westergaard's for waves.
Fields of any size are read piece by piece."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_file(
        parser,
        "file",
        metavar="OUT.h5",
        nargs="+",
        help="result file; the curves of several files are drawn together, those of more than six"
        " as mean and standard deviation",
    )
    add_file(
        parser,
        "-o",
        "--output",
        metavar="DIR|FILE",
        help="folder, or a file that ends in .png, .pdf or .svg (default: beside the result)",
    )
    parser.add_argument(
        "--what",
        metavar="NAME",
        nargs="+",
        help="pictures: maps, distributions, spectra, curves; a single field: contact, pressure,"
        " gap, heights, displacement, plastic, dent; a single curve: a_r, kappa, gap_mean,"
        " approach, or any number of the loads, such as conductance or critical_gap_x (default: the"
        " first four)",
    )
    parser.add_argument(
        "--step",
        metavar="K",
        nargs="+",
        type=int,
        help="load steps by number (default: at most four, evenly spaced)",
    )
    parser.add_argument(
        "--window",
        metavar=("X0", "X1", "Y0", "Y1"),
        nargs=4,
        help='part of the cell shown in maps, in the unit of its sizes or with units ("2um")',
    )
    parser.add_argument(
        "--dpi", type=int, help="dots per inch of maps and of .png files (default: 300)"
    )
    parser.add_argument(
        "--columns",
        metavar="N",
        type=int,
        help="panels beside each other; 1: below each other, in 85 mm",
    )
    parser.add_argument(
        "--dimensionless",
        action="store_true",
        help="label axes p/(E* g_rms) and gap/h_rms even if the scene has units",
    )
    parser.add_argument(
        "--persson",
        action="store_true",
        help="Persson's theory beside a measured map: the area of its g_rms, and the gap of its"
        " spectrum if output.distributions has heights_spectrum",
    )


def main(args: Namespace) -> int:
    """Draw pictures of results, save them, and print their names and remarks; returns 0."""
    from ..output.read import read_result
    from ..plotting import plot_result

    if args.dpi is not None and not 20 <= args.dpi <= 2400:
        raise SceneError(f"--dpi: found {args.dpi}, allowed: 20 to 2400")
    several = len(args.file) > 1
    if several and (args.step or args.window):
        raise SceneError("plot: --step and --window need a single file")
    results = [read_result(file) for file in args.file]
    paths = plot_result(
        results if several else results[0],
        args.output,
        args.what,
        step=args.step,
        window=args.window,
        dpi=args.dpi,
        dimensionless=args.dimensionless,
        columns=args.columns,
        persson=args.persson,
    )
    remarks = [] if several else [*_remarks(results[0], args), *results[0].remarks]
    print(*paths, *remarks, sep="\n")
    return 0


def _remarks(result: Any, args: Namespace) -> list[str]:
    """Return lines on load steps that are left out or not converged, then their notes."""
    from ..output.summary import converged
    from ..plotting import chosen_steps

    remarks = []
    pictures = {*(args.what or ["maps"])} - {"heights"}
    chosen = [chosen_steps(result, name, args.step) for name in pictures]
    drawn = [result.indices[k] for k in min(chosen, key=len, default=[])]
    left_out = [index for index in result.indices if index not in drawn]
    if left_out and drawn:
        remarks.append(
            f"shown: step {_list(drawn)}; left out: {_list(left_out)} (choose with --step)"
        )
    steps = result.numbered
    if inaccurate := [index for index, step in steps.items() if not converged(step)]:
        remarks.append(f"! not converged: step {_list(inaccurate)} (marked in the pictures)")
    notes = [f"step {index}: {step['note']}" for index, step in steps.items() if step.get("note")]
    return remarks + notes


def _list(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers))
