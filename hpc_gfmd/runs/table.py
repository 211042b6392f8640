"""The result table: one line per load step, plain ASCII for terminals and batch logs, or HTML for
notebooks."""

from collections.abc import Sequence
from html import escape
from typing import Any

from ..contact import all_numbers
from ..output.summary import converged, is_number, surface_line, with_error
from ..util.quantities import in_units, prefixed

ROOM = 9  # for the cells of rows that are not yet known
LEGEND = (
    "+-: estimated error of the solver on this grid; grid: estimated error of a_r by the size of a"
    " grid point, % of a_r"
)

# attribute, heading, estimated relative error or format; left out where no step has it
COLUMNS = (
    ("target_gap_mean", "asked: gap", None),
    ("target_gap_over_h_rms", "asked: gap/h_rms", None),
    ("target_a_r", "asked: a_r", None),
    ("target_force", "force", None),
    ("target_approach", "asked: approach", None),
    ("p_star", "p*", None),
    ("p", "p", None),
    ("a_r", "a_r", "a_r_error"),
    ("a_r_discretisation", "grid", ".2g"),
    ("kappa", "kappa", None),
    ("kappa_corrected", "kappa_corrected", None),
    ("gap_mean", "mean gap", "gap_error"),
    ("approach", "approach", None),
    ("gap_over_h_rms", "gap/h_rms", None),
    ("stiffness", "stiffness", None),
    ("patches", "patches", None),
    ("patch_largest", "patch_largest", None),
    ("perimeter", "perimeter", None),
    ("pressure_error", "error of p", ".2g"),
    ("iterations", "iter.", None),
    ("fft_pairs", "FFT pairs", ".1f"),
    ("wall_seconds", "time", ".3g"),
    ("precision", "precision", None),
    ("status", "status", None),
)
PER_CENT = {"a_r": "% +- solver", "a_r_discretisation": "%", "pressure_error": "%"}


def table(steps: list[dict], indices: list[int] | None = None, surface: dict | None = None) -> str:
    """Text for the steps, given as dicts of the attributes of the result file; surface: those of
    its surface, which know the units.

    Errors stand behind +- in the unit of their column: those of the solver. What the size of a grid
    point adds to that of a_r has a column of its own. A step that did not converge has a ! before
    its number and a line of its own below the table, as has a step with a `note`.
    """
    indices = list(range(len(steps))) if indices is None else indices
    return "\n".join([*_lines(cells(steps, indices, surface)), *remarks(indices, steps)])


class GrowingTable:
    """The same table, printed row by row as the steps of a surface finish."""

    def __init__(self, surface: dict):
        self._surface, self._steps = surface, dict[int, dict]()
        self._heading: list[list[str]] = []

    def add(self, steps: dict[int, dict]) -> str:
        """Rows of more steps, by their numbers; above them the headings where these are not the
        last ones any more, as in other units."""
        self._steps |= steps
        rows = cells([*self._steps.values()], [*self._steps], self._surface)
        lines, same = _lines(rows, ROOM), rows[:2] == self._heading
        self._heading = rows[:2]
        return "\n".join([*(() if same else lines[:2]), *lines[-len(steps) :]])

    def end(self) -> list[str]:
        """What is said below the rows, a line each."""
        return remarks([*self._steps], [*self._steps.values()])


def _lines(rows: list[list[str]], least: int = 0) -> list[str]:
    """Texts of rows of cells, each column as wide as its widest cell, and at least so wide."""
    widths = [max(least, *map(len, column)) for column in zip(*rows)]
    lines = ("  ".join(map(str.rjust, row, widths)) for row in rows)
    return [line.rstrip() for line in lines]


def html_table(
    steps: list[dict],
    surface: dict,
    indices: list[int] | None = None,
    notes: Sequence[str] = (),
    across: bool = True,
) -> str:
    """HTML of what `table` says; across: a row for each step, otherwise a column."""
    indices = list(range(len(steps))) if indices is None else indices
    rows = cells(steps, indices, surface)
    if not across:
        rows = [list(row) for row in zip(*rows)][1:]
    lines = [
        "<tr>"
        + "".join(f'<td style="text-align:right">{escape(cell)}</td>' for cell in row)
        + "</tr>"
        for row in rows
    ]
    below = [surface_line(surface), *remarks(indices, steps), *(f"note: {note}" for note in notes)]
    return "\n".join(
        [
            "<table>",
            *lines,
            "</table>",
            "<small>" + "<br>".join(escape(line) for line in below) + "</small>",
        ]
    )


def cells(steps: list[dict], indices: list[int], surface: dict | None = None) -> list[list[str]]:
    """The same as rows of texts: headings, units, and one row per step."""
    columns = [
        [
            "step",
            "",
            *(
                f"{index}" if converged(step) else f"! {index}"
                for index, step in zip(indices, steps, strict=True)
            ),
        ]
    ]
    for key, name, how in COLUMNS:
        values = [
            step[key] if isinstance(step.get(key), int | float | str) else None for step in steps
        ]  # of any file
        if any(value is not None for value in values):
            scale, heading = _scale(
                key, [value for value in values if is_number(value)], surface or {}
            )
            columns.append(
                [
                    name,
                    heading,
                    *(_cell(value, scale, how, step) for value, step in zip(values, steps)),
                ]
            )
    return [list(row) for row in zip(*columns)]


def _scale(key: str, values: list[float], surface: dict) -> tuple[float, str]:
    """(scale, heading) of a column: with the prefix that suits its largest value where the surface
    knows the unit, a_r and errors in per cent."""
    if key in PER_CENT:
        return 0.01, f"[{PER_CENT[key]}]"
    unit = all_numbers()[key][1]
    named = in_units(unit, surface)
    if named in ("", "1", unit):
        return 1.0, unit and f"[{unit.replace('pressure', 'E*')}]"
    base, square, _ = named.partition("^2")
    scale, name = prefixed([abs(value) ** 0.5 for value in values] if square else values, base)
    return (scale**2 if square else scale), f"[{name}{square}]"


def _cell(value: Any, scale: float, how: str | None, step: dict) -> str:
    if value is None or isinstance(value, str):
        return value or "-"
    value = value if scale == 1 else value / scale
    if how and how.startswith("."):
        return f"{value:{how}}" if value < 1000 else f"{value:.0f}"
    error = step.get(how) if is_number(step.get(how)) else None
    return with_error(value, error) if isinstance(value, float) or error else str(value)


def remarks(indices: list[int], steps: list[dict]) -> list[str]:
    """What to say below the table, a line each."""
    remarks = [LEGEND] if any("a_r_discretisation" in step for step in steps) else []
    for index, step in zip(indices, steps, strict=True):
        if not converged(step):
            status = step.get("status", "unknown")
            remarks.append(f"! step {index}: NOT CONVERGED ({status}), less accurate than asked")
    for note in dict.fromkeys(step["note"] for step in steps if step.get("note")):
        said = [
            index for index, step in zip(indices, steps, strict=True) if step.get("note") == note
        ]
        where = f"step {said[0]}" if len(said) == 1 else f"steps {', '.join(map(str, said))}"
        remarks.append(f"  {where}: {note}")
    return remarks
