"""The result table: one line per load step, plain ASCII for terminals and batch logs, or HTML."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from math import inf, isfinite
from typing import Any

from ..contact import all_numbers, observables_named
from ..output.result import Result
from ..output.summary import converged, error_bars, estimate, is_number, pull_off_line, surface_line
from ..util.quantities import in_units, prefixed

NARROWEST = 9  # width of columns whose later rows are not known yet
LEGEND = "+-: estimated error, of the solver and of the grid together (--errors: apart)"
CORRECTED = (
    "a_r: share of grid points in contact, too large by what points at the edge of the contact add;"
    " corrected: without them"
)
TIME_STEPS = "+-: without the error of the time steps (see hpc-gfmd run --halve-steps)"
NO_COARSER_GRID = "no coarser grid was solved, of the mean gap it is the solver's alone"
NO_LIMIT = (
    "max p +- ?: where the contact reaches a free edge or a ridge between mirror images it grows"
    " without limit on finer grids; in a patch of one or two points of a profile it is not known"
)
NO_AREA = "mean p contact +- ?: by its error the area may be 0"

# attribute: heading; a column is left out where no step has a value
TARGETS = {
    "time": "at time",
    "target_gap_mean": "asked: gap",
    "target_gap_over_h_rms": "asked: gap/h_rms",
    "target_a_r": "asked: a_r",
    "target_force": "force",
    "target_approach": "asked: approach",
}
RESULTS = {
    "p_star": "p*",
    "p": "p",
    "a_r": "a_r",
    "a_r_corrected": "corrected",
    "contact_area": "contact area",
    "kappa": "kappa",
    "contact_pressure_mean": "mean p contact",
    "contact_pressure_max": "max p",
    "gap_mean": "mean gap",
    "approach": "approach",
    "gap_over_h_rms": "gap/h_rms",
}
ERRORS = {
    "a_r_error": "a_r: solver",
    "a_r_discretisation": "a_r: grid",
    "gap_error": "gap: solver",
    "gap_discretisation": "gap: grid",
    "p_error": "p: solver",
    "pressure_error": "p field: solver",
    "pressure_max_discretisation": "max p: grid",
}
EFFORT = {
    "fft_pairs": "FFT pairs",
    "wall_seconds": "time",
    "precision": "precision",
    "status": "status",
}
FORMATS = {"fft_pairs": ".1f", "wall_seconds": ".3g", **dict.fromkeys(ERRORS, ".2g")}
PER_CENT = ("a_r", "a_r_corrected", *ERRORS)


def table(
    steps: Mapping[int, dict], surface: dict, observables: Iterable[str] = (), errors: bool = False
) -> str:
    """Return the table of load steps as text; errors have their own columns or follow +-."""
    observables = tuple(observables)
    rows = cells(steps, surface, observables, errors)
    return "\n".join([*aligned(rows), *remarks(steps, surface, observables)])


def result_table(result: Result, errors: bool = False) -> str:
    """Return the table of a result as text, with its notes below."""
    rows = table(result.numbered, result.surface, named_observables(result), errors)
    return "\n".join([rows, *(f"note: {note}" for note in result.notes)])


class GrowingTable:
    """The table of `table`, row by row while the steps are solved."""

    def __init__(self, surface: dict, observables: Iterable[str] = ()):
        self._surface = surface
        self._observables = tuple(observables)
        self._steps: dict[int, dict] = {}
        self._heading: list[list[str]] = []

    def add(self, steps: dict[int, dict]) -> str:
        """Add new steps and return their rows, after headings if these have changed."""
        self._steps |= steps
        rows = cells(self._steps, self._surface, self._observables)
        lines = aligned(rows, NARROWEST)
        heading = rows[:2]
        shown = lines[-len(steps) :]
        if heading != self._heading:
            shown = [*lines[:2], *shown]
        self._heading = heading
        return "\n".join(shown)

    def end(self) -> list[str]:
        """Return the lines below the table, for all steps so far."""
        return remarks(self._steps, self._surface, self._observables)


def aligned(rows: list[list[str]], narrowest: int = 0) -> list[str]:
    """Return rows of cells as lines, each column as wide as its widest cell."""
    widths = [max(narrowest, *map(len, column)) for column in zip(*rows)]
    lines = ("  ".join(map(str.rjust, row, widths)) for row in rows)
    return [line.rstrip() for line in lines]


def html_table(result: Result, across: bool = True) -> str:
    """Return a result as an HTML table, steps as rows or columns, surface and notes below."""
    steps = result.numbered
    surface = result.surface
    observables = named_observables(result)
    rows = cells(steps, surface, observables)
    if not across:
        _, *rows = [list(column) for column in zip(*rows)]  # without the numbers of the steps
    notes = (f"note: {note}" for note in result.notes)
    return html(rows, [surface_line(surface), *remarks(steps, surface, observables), *notes])


def html(rows: list[list[str]], below: Iterable[str]) -> str:
    """Return rows of cells as an HTML table, with lines below."""
    from pandas import DataFrame

    shown = DataFrame(rows).to_html(header=False, index=False, border=0)
    return f"{shown}\n<small>{'<br>'.join(map(escape, below))}</small>"


def named_observables(result: Result) -> tuple[str, ...]:
    """Return the observables that the scene of a result requests; () if its scene is not valid."""
    scene = result.readable_scene
    return tuple(scene.output.observables or ()) if scene else ()


def cells(
    steps: Mapping[int, dict], surface: dict, observables: Sequence[str] = (), errors: bool = False
) -> list[list[str]]:
    """Return the table as rows of texts: headings, units, and one row per step."""
    named = {name: name for name in observables_named(observables)}
    headings = TARGETS | RESULTS | named | (ERRORS if errors else {}) | EFFORT
    headings |= {name: RESULTS[name] for name in named if name in RESULTS}
    marked = (f"{'' if converged(step) else '! '}{k}" for k, step in steps.items())
    columns = [["step", "", *marked]]
    for key, heading in headings.items():
        values = [_shown_value(step.get(key)) for step in steps.values()]
        if key in named or any(value is not None for value in values):
            scale, unit = column_scale(key, list(filter(is_number, values)), surface)
            texts = (
                _cell(key, value, scale, step)
                for value, step in zip(values, steps.values(), strict=True)
            )
            columns.append([heading, unit, *texts])
    return [list(row) for row in zip(*columns)]


def _shown_value(value: Any) -> float | str | None:
    """Return a number or a text as it is, and None for anything else that a file may hold."""
    return value if isinstance(value, int | float | str) else None


def column_scale(key: str, values: list[float], surface: dict) -> tuple[float, str]:
    """Return the divisor of a column, by its largest value, and its unit in brackets."""
    if key in PER_CENT:
        return 0.01, "[%]"
    unit = all_numbers()[key][1]
    named = in_units(unit, surface)
    if named in ("", "1", unit):
        return 1.0, unit and f"[{unit}]"
    if named.startswith("1/"):
        return 1.0, f"[{named}]"
    base, square, _ = named.partition("^2")
    scale, name = prefixed([abs(value) ** 0.5 for value in values] if square else values, base)
    return (scale**2 if square else scale), f"[{name}{square}]"


def _cell(key: str, value: Any, scale: float, step: dict) -> str:
    """Return a number of a step over `scale` with its error if known; "-" for None."""
    if value is None or isinstance(value, str):
        return value or "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    value = value if scale == 1 else value / scale
    if number_format := FORMATS.get(key):
        return f"{value:{number_format}}" if value < 1000 else f"{value:.0f}"
    return estimate(value, key, step) if isinstance(value, float) else str(value)


def remarks(steps: Mapping[int, dict], surface: dict, observables: Sequence[str] = ()) -> list[str]:
    """Return the lines below the table: legend, pull-off, notes, what failed or has no value."""
    lines = [LEGEND] if any("a_r_discretisation" in step for step in steps.values()) else []
    unknown = [
        f"{index}"
        for index, step in steps.items()
        if _has_value(step.get("gap_mean")) and not _has_value(step.get("gap_discretisation"))
    ]
    if lines and unknown:
        steps_text = f"at step{'s' * (len(unknown) > 1)} {', '.join(unknown)} "
        lines[0] += f"; {steps_text if len(unknown) < len(steps) else ''}{NO_COARSER_GRID}"
    if len({step.get("time") for step in steps.values()}) > 1:
        lines.append(TIME_STEPS)
    if any(_has_value(step.get("a_r_corrected")) for step in steps.values()):
        lines.append(CORRECTED)
    if any(step.get("pressure_max_discretisation") == inf for step in steps.values()):
        lines.append(NO_LIMIT)
    of_pressure = "contact_pressure_mean"
    touching = [step for step in steps.values() if _has_value(step.get(of_pressure))]
    if any(inf in (error_bars(of_pressure, step) or ()) for step in touching):
        lines.append(NO_AREA)
    if pull_off := pull_off_line([*steps.values()], surface):
        lines.append(pull_off)
    numbers_of_note: dict[str, list[str]] = {}
    for index, step in steps.items():
        if not converged(step):
            status = step.get("status", "unknown")
            lines.append(f"! step {index}: NOT CONVERGED ({status}), less accurate than asked")
        if step.get("note"):
            numbers_of_note.setdefault(step["note"], []).append(f"{index}")
    for name, observable in observables_named(observables).items():
        without = [f"{index}" for index, step in steps.items() if not _has_value(step.get(name))]
        if without and observable.absent:
            reason = f"{name} has no value: {observable.absent}"
            numbers_of_note[reason] = without
    return lines + [
        f"  step{'s' * (len(numbers) > 1)} {', '.join(numbers)}: {note}"
        for note, numbers in numbers_of_note.items()
    ]


def _has_value(value: Any) -> bool:
    return value is not None and not (isinstance(value, float) and not isfinite(value))
