"""The result table: one line per load step, plain ASCII for terminals and batch logs, or HTML for
notebooks; and one line on a load step and on a surface."""

from collections.abc import Sequence
from html import escape
from math import floor, isfinite, log10, nan
from typing import Any, TypeGuard

from ..util.quantities import prefixed

DIGITS = 4  # of a number without an error estimate
MAX_DIGITS = 6
ROOM = 9  # for the cells of rows that are not yet known
LEGEND = (
    "+-: estimated error of the solver on this grid; grid: estimated error of a_r by the size of a"
    " grid point, % of a_r"
)

# attribute, heading, what it is measured in, estimated relative error or format; left out where no
# step has it
COLUMNS = (
    ("target_gap_mean", "asked: gap", "length", None),
    ("target_gap_over_h_rms", "asked: gap/h_rms", "", None),
    ("target_a_r", "asked: a_r", "", None),
    ("target_force", "force", "force", None),
    ("target_approach", "asked: approach", "length", None),
    ("p_star", "p*", "", None),
    ("p", "p", "unit of E*", None),
    ("a_r", "a_r", "% +- solver", "a_r_error"),
    ("a_r_discretisation", "grid", "%", ".2g"),
    ("kappa", "kappa", "", None),
    ("kappa_corrected", "kappa_corrected", "", None),
    ("gap_mean", "mean gap", "length", "gap_error"),
    ("approach", "approach", "length", None),
    ("gap_over_h_rms", "gap/h_rms", "", None),
    ("stiffness", "stiffness", "E*/length", None),
    ("patches", "patches", "", None),
    ("patch_largest", "patch_largest", "length^2", None),
    ("perimeter", "perimeter", "length", None),
    ("pressure_error", "error of p", "%", ".2g"),
    ("iterations", "iter.", "", None),
    ("fft_pairs", "FFT pairs", "", ".1f"),
    ("wall_seconds", "time", "s", ".3g"),
    ("precision", "precision", "", None),
    ("status", "status", "", None),
)


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
        self._heading: list[str] = []

    def add(self, steps: dict[int, dict]) -> str:
        """Rows of more steps, by their numbers; above them the headings where these are not the
        last ones any more: of a wider column, or in other units."""
        self._steps |= steps
        lines = _lines(cells([*self._steps.values()], [*self._steps], self._surface), ROOM)
        before, self._heading = self._heading, lines[:2]
        return "\n".join([*(lines[:2] if lines[:2] != before else ()), *lines[-len(steps) :]])

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
    for key, name, unit, how in COLUMNS:
        values = [
            step[key] if isinstance(step.get(key), int | float | str) else None for step in steps
        ]  # of any file
        if any(value is not None for value in values):
            scale, heading = _scale(
                unit, [value for value in values if _is_number(value)], surface or {}
            )
            columns.append(
                [
                    name,
                    heading,
                    *(_cell(value, scale, how, step) for value, step in zip(values, steps)),
                ]
            )
    return [list(row) for row in zip(*columns)]


def summary(step: dict, surface: dict) -> str:
    """What matters most of a step, in one line with units."""
    parts = []
    if step.get("a_r") is not None:
        grid = step.get("a_r_discretisation")
        parts.append(
            f"a_r = {with_error(100 * step['a_r'], step.get('a_r_error'))} %"
            + (f" (solver), +- {100 * grid:.2g} % of it (grid)" if _is_number(grid) else "")
        )
    for name, key, unit, error in (
        ("p", "p", "pressure_unit", None),
        ("mean gap", "gap_mean", "unit", "gap_error"),
    ):
        if step.get(key) is not None:
            scale, unit = prefixed([step[key]], surface.get(unit, ""))
            parts.append(
                f"{name} = {with_error(step[key] / scale, step.get(error))} {unit}".strip()
            )
    if isfinite(step.get("p_star", nan)):
        parts.append(f"p* = {step['p_star']:.{DIGITS}g}")
    parts.append(step["status"] if converged(step) else f"NOT CONVERGED ({step['status']})")
    return ", ".join(parts) + (f"; note: {step['note']}" if step.get("note") else "")


def _scale(kind: str, values: list[float], surface: dict) -> tuple[float, str]:
    """(scale, heading) of a column: with the prefix that suits its largest value where the surface
    knows the unit, a_r in per cent."""
    length, pressure = _text(surface, "unit"), _text(surface, "pressure_unit")
    both = length and pressure
    known = {
        "length": length,
        "unit of E*": pressure,
        "force": both and "N",
        "E*/length": both and f"{pressure}/{length}",
    }
    if kind == "length^2" and length:
        scale, unit = prefixed([abs(value) ** 0.5 for value in values], length)
        return scale**2, f"[{unit}^2]"
    scale, unit = (
        prefixed(values, known[kind])
        if known.get(kind)
        else (0.01 if kind.startswith("%") else 1.0, kind)
    )
    return scale, unit and f"[{unit}]"


def converged(step: dict) -> bool:
    """Whether the step reached the accuracy that the scene asks for."""
    return step.get("status") == "converged"


def with_error(value: float, relative: float | None) -> str:
    """ "0.0160 +- 0.0002" for a value and its relative error: digits as far as they mean
    something."""
    if not isfinite(value):
        return str(value)
    if not relative or not value:
        return f"{value:.{DIGITS}g}" + (" +- 0" if relative == 0 else "")
    if not isfinite(relative):
        return f"{value:.{DIGITS}g} +- ?"
    error = abs(value * relative)
    place = floor(log10(abs(value)))  # of the leading digit
    scale = 0 if -4 <= place <= 5 else place
    smallest = place - MAX_DIGITS + 1
    last = max(smallest, floor(log10(error)))
    decimals = max(0, scale - min(last, place))
    shown = f"{value / 10.0**scale:.{decimals}f}"
    uncertain = (
        f"{error / 10.0**scale:.{decimals}f}"
        if error >= 10.0**last
        else f"{error / 10.0**scale:.0e}"
    )
    return f"{shown} +- {uncertain}" if scale == 0 else f"({shown} +- {uncertain})e{scale:+03d}"


def surface_line(surface: dict) -> str:
    """One line about the surface: points, size, roughness and the three ratios of lengths."""
    parts = []
    if points := _numbers(surface.get("n")):
        parts.append(" x ".join(f"{n:.0f}" for n in points) + " points")
    if sizes := _numbers(surface.get("physical_sizes")):
        scale, unit = prefixed(sizes, _text(surface, "unit"))
        parts.append(
            " ".join(["L =", " x ".join(f"{size / scale:.4g}" for size in sizes), unit]).strip()
        )
    if _is_number(surface.get("h_rms")) and isfinite(surface["h_rms"]):
        scale, unit = prefixed([surface["h_rms"]], _text(surface, "unit"))
        parts.append(f"h_rms = {surface['h_rms'] / scale:.{DIGITS}g} {unit}".strip())
    for name in ("hurst", "g_rms", "eps_t", "eps_f", "eps_c"):
        if _is_number(surface.get(name)) and isfinite(surface[name]):
            parts.append(f"{name} = {surface[name]:.{DIGITS}g}")
    if surface.get("prepared"):
        parts.append(str(surface["prepared"]))
    if isinstance(surface.get("seed"), int) and surface["seed"] >= 0:  # other surfaces have none
        parts.append(f"seed = {surface['seed']}")
    return ", ".join(parts)


def _numbers(found: object) -> list[float]:
    """A list of finite numbers as it is, anything else as none: files may hold what they like."""
    if isinstance(found, list | tuple) and all(_is_number(x) and isfinite(x) for x in found):
        return list(found)
    return []


def _is_number(found: object) -> TypeGuard[float]:
    return isinstance(found, int | float)


def _text(surface: dict, key: str) -> str:
    return surface[key] if isinstance(surface.get(key), str) else ""


def _cell(value: Any, scale: float, how: str | None, step: dict) -> str:
    if value is None or isinstance(value, str):
        return value or "-"
    value = value if scale == 1 else value / scale
    if how and how.startswith("."):
        return f"{value:{how}}" if value < 1000 else f"{value:.0f}"
    error = step.get(how) if _is_number(step.get(how)) else None
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
