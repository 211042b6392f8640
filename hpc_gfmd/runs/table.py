"""The result table: one line per load step, plain ASCII for terminals and batch logs, or HTML for
notebooks."""

from collections.abc import Mapping
from html import escape
from typing import Any

from ..contact import all_numbers
from ..output.read import Result
from ..output.summary import converged, is_number, surface_line, with_error
from ..util.quantities import in_units, prefixed

ROOM = 9  # for the cells of rows that are not yet known
LEGEND = (
    "+-: estimated error of the solver on this grid; grid: estimated error of a_r by the size of a"
    " grid point, % of a_r"
)

# attribute: heading; left out where no step has it
COLUMNS = {
    "target_gap_mean": "asked: gap",
    "target_gap_over_h_rms": "asked: gap/h_rms",
    "target_a_r": "asked: a_r",
    "target_force": "force",
    "target_approach": "asked: approach",
    "p_star": "p*",
    "p": "p",
    "a_r": "a_r",
    "a_r_discretisation": "grid",
    "kappa": "kappa",
    "kappa_corrected": "kappa_corrected",
    "gap_mean": "mean gap",
    "approach": "approach",
    "gap_over_h_rms": "gap/h_rms",
    "stiffness": "stiffness",
    "patches": "patches",
    "patch_largest": "patch_largest",
    "perimeter": "perimeter",
    "pressure_error": "error of p",
    "iterations": "iter.",
    "fft_pairs": "FFT pairs",
    "wall_seconds": "time",
    "precision": "precision",
    "status": "status",
}
ERRORS = {"a_r": "a_r_error", "gap_mean": "gap_error"}  # estimated relative ones
DIGITS = {
    "a_r_discretisation": ".2g",
    "pressure_error": ".2g",
    "fft_pairs": ".1f",
    "wall_seconds": ".3g",
}
PER_CENT = {"a_r": "% +- solver", "a_r_discretisation": "%", "pressure_error": "%"}


def table(steps: Mapping[int, dict], surface: dict) -> str:
    """Write the table of steps, by number the attributes of the result file; surface: those of its
    surface, which know the units.

    Errors stand behind +- in the unit of their column: those of the solver. What the size of a grid
    point adds to that of a_r has a column of its own. A step that did not converge has a ! before
    its number and a line of its own below the table, as has a step with a `note`.
    """
    return "\n".join([*_lines(cells(steps, surface)), *remarks(steps)])


class GrowingTable:
    """The same table, printed row by row as the steps of a surface finish."""

    def __init__(self, surface: dict):
        self._surface, self._steps = surface, dict[int, dict]()
        self._heading: list[list[str]] = []

    def add(self, steps: dict[int, dict]) -> str:
        """Write rows of more steps, by their numbers; above them the headings where they are not
        those that were written last, as in other units."""
        self._steps |= steps
        rows = cells(self._steps, self._surface)
        lines, same = _lines(rows, ROOM), rows[:2] == self._heading
        self._heading = rows[:2]
        return "\n".join([*(() if same else lines[:2]), *lines[-len(steps) :]])

    def end(self) -> list[str]:
        """List what is said below the rows, a line each."""
        return remarks(self._steps)


def _lines(rows: list[list[str]], least: int = 0) -> list[str]:
    """Write rows of cells, each column as wide as its widest cell, and at least so wide."""
    widths = [max(least, *map(len, column)) for column in zip(*rows)]
    lines = ("  ".join(map(str.rjust, row, widths)) for row in rows)
    return [line.rstrip() for line in lines]


def html_table(result: Result, across: bool = True) -> str:
    """Write HTML of what `table` says; across: a row for each step, otherwise a column."""
    from pandas import DataFrame

    steps, surface = result.numbered, result.surface
    rows = DataFrame(cells(steps, surface))
    shown = (rows if across else rows.T[1:]).to_html(header=False, index=False, border=0)
    notes = (f"note: {note}" for note in result.notes)
    below = [surface_line(surface), *remarks(steps), *notes]
    return f"{shown}\n<small>{'<br>'.join(map(escape, below))}</small>"


def cells(steps: Mapping[int, dict], surface: dict) -> list[list[str]]:
    """Return the table as rows of texts: headings, units, and one row per step."""
    marked = (f"{'! ' * (not converged(step))}{k}" for k, step in steps.items())
    columns = [["step", "", *marked]]
    for key, name in COLUMNS.items():
        found = [step.get(key) for step in steps.values()]
        # a file that another program wrote may hold anything
        values = [x if isinstance(x, int | float | str) else None for x in found]
        if any(value is not None for value in values):
            scale, heading = _scale(key, list(filter(is_number, values)), surface)
            shown = (_cell(key, value, scale, step) for value, step in zip(values, steps.values()))
            columns.append([name, heading, *shown])
    return [list(row) for row in zip(*columns)]


def _scale(key: str, values: list[float], surface: dict) -> tuple[float, str]:
    """Return (scale, heading) of a column: with the prefix that suits its largest value where the
    surface knows the unit, a_r and errors in per cent."""
    if key in PER_CENT:
        return 0.01, f"[{PER_CENT[key]}]"
    unit = all_numbers()[key][1]
    named = in_units(unit, surface)
    if named in ("", "1", unit):
        return 1.0, unit and f"[{unit.replace('pressure', 'E*')}]"
    base, square, _ = named.partition("^2")
    scale, name = prefixed([abs(value) ** 0.5 for value in values] if square else values, base)
    return (scale**2 if square else scale), f"[{name}{square}]"


def _cell(key: str, value: Any, scale: float, step: dict) -> str:
    if value is None or isinstance(value, str):
        return value or "-"
    value = value if scale == 1 else value / scale
    if how := DIGITS.get(key):
        return f"{value:{how}}" if value < 1000 else f"{value:.0f}"
    error = step.get(ERRORS.get(key, ""))
    error = error if is_number(error) else None
    return with_error(value, error) if isinstance(value, float) or error else str(value)


def remarks(steps: Mapping[int, dict]) -> list[str]:
    """List what to say below the table, a line each."""
    remarks = [LEGEND] if any("a_r_discretisation" in step for step in steps.values()) else []
    said: dict[str, list[str]] = {}
    for index, step in steps.items():
        if not converged(step):
            status = step.get("status", "unknown")
            remarks.append(f"! step {index}: NOT CONVERGED ({status}), less accurate than asked")
        if step.get("note"):
            said.setdefault(step["note"], []).append(f"{index}")
    return remarks + [
        f"  step{'s' * (len(found) > 1)} {', '.join(found)}: {note}" for note, found in said.items()
    ]
