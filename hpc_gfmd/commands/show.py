"""`hpc-gfmd show`: the numbers of a result file, as a table or as JSON."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from ..util.errors import SceneError
from .common import add_file, add_json, as_json

if TYPE_CHECKING:
    from ..output.result import Result

HELP = "the result table of a file"
DESCRIPTION = """
Print the results of a finished, running or interrupted run. Lengths are in the unit of the surface,
pressures in that of E_star. +- is the estimated error, of the contact area that of the solver and
that caused by the grid spacing together."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_file(
        parser,
        "file",
        metavar="OUT.h5",
        nargs="+",
        help="result file; for several with the same loads means and standard deviations are shown",
    )
    add_json(parser, "a table")
    parser.add_argument(
        "--errors",
        action="store_true",
        help="show the errors of solver and grid in separate columns",
    )
    parser.add_argument(
        "--tfc",
        metavar="TABLE",
        nargs="?",
        const="ours",
        help="extrapolate kappa and gap/h_rms to the thermodynamic, fractal and continuum limits"
        " with the coefficients of TABLE: paper, ours (default) or a JSON file",
    )
    parser.add_argument(
        "--persson",
        action="store_true",
        help="Persson's theory beside the results: of a measured map that of its g_rms, and of its"
        " spectrum if output.distributions has heights_spectrum; Hertz's and Westergaard's beside"
        " spheres and waves",
    )
    parser.add_argument(
        "--references", action="store_true", help="list the papers to cite for these numbers"
    )


def main(args: Namespace) -> int:
    """Print one result, or means of several, as a table or JSON; returns 0."""
    from ..output.read import read_result

    if len(args.file) > 1:
        return _show_ensemble(args)
    result = read_result(args.file[0])
    data = as_dict(result)
    text = as_text(result, args.errors)
    if args.tfc is not None:
        from .limits import limits_text, to_limits

        limits = to_limits(result, args.tfc or "ours")
        data["tfc"] = limits
        text += f"\n\n{limits_text(limits)}"
    if args.persson:
        from .beside import theory_text, to_theory

        theory = to_theory(result)
        data["theory"] = theory
        text += f"\n\n{theory_text(result, theory)}"
    if args.references:
        from ..runs.references import references_of

        papers = references_of(result)
        data["references"] = papers
        text = "\n".join([text, "", "to cite:", *papers])
    print(as_json(data, 1) if args.json else text)
    for note in result.notes if args.json else ():
        print(f"note: {note}", file=sys.stderr)
    return 0


def _show_ensemble(args: Namespace) -> int:
    """Print means and standard deviations of several results, as text or JSON; returns 0."""
    from ..runs.ensemble import Ensemble

    if args.tfc is not None or args.references or args.errors or args.persson:
        raise SceneError("show: found several files, allowed with --json alone")
    ensemble = Ensemble(args.file)
    if args.json:
        table = ensemble.to_dataframe()
        columns = {name: table[name].tolist() for name in table}
        report = {"results": len(ensemble), "units": table.attrs["units"], "loads": columns}
        print(as_json(report, 1))
    else:
        print(ensemble.table())
    return 0


def as_dict(result: Result) -> dict:
    """Return {"surface": ..., "steps": ..., "status": ...} of a result, for JSON."""
    return {"surface": result.surface, "steps": result.steps, "status": result.status}


def as_text(result: Result, errors: bool = False) -> str:
    """Return head, table and notes of a result, `errors` of solver and grid in columns."""
    from ..output.summary import surface_line
    from ..runs.table import result_table

    lines = [f"{result.path}: {result.status}"]
    if result.folder is not None:
        lines.append(f"finished load steps of an unfinished run, from {result.folder}")
    if line := surface_line(result.surface):
        lines.append(line)
    lines.append(result_table(result, errors) if result.steps else "no finished load step yet")
    return "\n".join(lines)
