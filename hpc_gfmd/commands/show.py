"""`hpc-gfmd show`: what a result file says, as a table or as JSON."""

import sys
from argparse import Namespace

from ..output.read import Result, read_result
from ..output.summary import surface_line
from ..runs.table import asked_of, table
from .common import as_json


def main(args: Namespace) -> int:
    """Print a result; raises SceneError if the file is missing, damaged, foreign or too new."""
    result = read_result(args.file)
    shown = as_dict(result)
    text = as_text(result, args.errors)
    if args.tfc is not None:
        from .limits import limits_text, to_limits

        limits = to_limits(result, args.tfc or "ours")
        shown, text = shown | {"tfc": limits}, f"{text}\n\n{limits_text(limits)}"
    if args.references:
        from ..runs.references import references_of

        found = references_of(result)
        shown, text = shown | {"references": found}, "\n".join([text, "", "to cite:", *found])
    print(as_json(shown, 1) if args.json else text)
    for note in result.notes if args.json else ():
        print(f"note: {note}", file=sys.stderr)
    return 0


def as_dict(result: Result) -> dict:
    """Return surface, steps and status with the names of the file."""
    return {"surface": result.surface, "steps": result.steps, "status": result.status}


def as_text(result: Result, errors: bool = False) -> str:
    """Return head, table and remarks; errors: with those of solver and grid apart."""
    lines = [f"{result.path}: {result.status}"]
    if result.folder is not None:
        lines.append(f"the finished load steps of an unfinished run, from {result.folder}")
    if line := surface_line(result.surface):
        lines.append(line)
    lines.append(
        table(result.numbered, result.surface, asked_of(result), errors)
        if result.steps
        else "no finished load step yet"
    )
    return "\n".join([*lines, *(f"note: {note}" for note in result.notes)])
