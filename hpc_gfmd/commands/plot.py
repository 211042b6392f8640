"""`hpc-gfmd plot`: the pictures of a result file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..util.errors import GfmdError, SceneError, reason
from .common import add_file

if TYPE_CHECKING:
    from ..output.result import Result
    from ..plotting.style import Picture

HELP = "pictures of a result"
DESCRIPTION = """
Draw the contents of a result: maps (of output.fields), spectra (of output.distributions),
distributions (of either), area and gap against load. Axes have units where the scene has them.
Persson's theory is drawn for self-affine surfaces, Hertz's for spheres, Westergaard's for waves.
Fields of any size are read piece by piece."""

SUFFIXES = (".png", ".pdf", ".svg")
OTHER_SUFFIXES = (".eps", ".gif", ".jpeg", ".jpg", ".ps", ".tif", ".tiff", ".webp")  # of pictures


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

    if args.dpi is not None and not 20 <= args.dpi <= 2400:
        raise SceneError(f"--dpi: found {args.dpi}, allowed: 20 to 2400")
    several = len(args.file) > 1
    if several and (args.step or args.window):
        raise SceneError("plot: --step and --window need a single file")
    results = [read_result(file) for file in args.file]
    paths = save_pictures(
        results,
        Path(args.output) if args.output else None,
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


def save_pictures(
    results: Sequence[Result],
    where: Path | None = None,
    names: Sequence[str] | None = None,
    **how: Any,
) -> list[Path]:
    """Draw the `figures` of results, save them, and return their paths. where: a folder, made if
    its parent exists, or a file, with names appended for several; default: RESULT.png beside a
    single result, else curves.png.
    """
    if where is None:
        path = results[0].path if len(results) == 1 else None
        where = path.with_suffix(".png") if path else Path("curves.png")
    if where.suffix.lower() in OTHER_SUFFIXES and not where.is_dir():
        endings = ", ".join(SUFFIXES)
        raise SceneError(f"-o: found {where}, allowed: a folder, or a file that ends in {endings}")
    drawn = figures(results, names, **how)
    several = len(drawn) > 1
    return [_save(fig, where, name, several, how.get("dpi")) for name, fig in drawn.items()]


def figures(
    results: Sequence[Result], names: Sequence[str] | None = None, **how: Any
) -> dict[str, Picture]:
    """Draw pictures by name; default: of maps, distributions, spectra and curves what a result has,
    maps only with a window, and of several results the curves.
    """
    from ..runs.plot import plot

    if len(results) > 1:
        return {name: plot([*results], name, **how) for name in names or ["curves"]}
    (result,) = results
    if not result.steps:
        raise SceneError(f"{result.path}: no finished load step yet, nothing to draw")
    return {name: plot(result, name, **how) for name in names or _pages_of(result, how)}


def _pages_of(result: Result, how: dict[str, Any]) -> list[str]:
    """Return the names of the pictures that are drawn of a result by default."""
    from ..runs.plot import PAGES, chosen_steps

    if how.get("window"):
        return ["maps"]
    possible = [name for name in PAGES if chosen_steps(result, name, how.get("step"))]
    if len(result.steps) == 1 and len(possible) > 1:
        possible = [name for name in possible if name != "curves"]
    return possible


def _save(fig: Picture, where: Path, name: str, several: bool, dpi: float | None) -> Path:
    """Save a picture as `where` (.png, .pdf or .svg), or as NAME.png in the folder `where`."""
    from ..plotting.style import save

    as_file = where.suffix.lower() in SUFFIXES and not where.is_dir()
    folder = where.parent if as_file else where
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise SceneError(f"-o: pictures cannot go to {folder} ({reason(error)})") from None
    path = folder / f"{name}.png"
    if as_file:
        path = where.with_stem(f"{where.stem}_{name}") if several else where
    try:
        save(fig, path, dpi)
    except OSError as error:
        raise GfmdError(f"writing {path}: {reason(error)}") from error
    return path


def _remarks(result: Any, args: Namespace) -> list[str]:
    """Return lines on load steps that are left out or not converged, then their notes."""
    from ..output.summary import converged
    from ..runs.plot import chosen_steps

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
