"""Rows, which are dicts: choosing among them, and writing them as text."""

import csv
import io
import re
import textwrap
from collections.abc import Iterator
from contextlib import suppress
from itertools import groupby, zip_longest
from operator import itemgetter
from string import Formatter
from typing import Any

Rows = list[dict]
CELL = 115  # characters of a cell of a table that readers take in
PRESSURES = {"low": 0.01 / 2**0.5, "high": 0.5 / 2**0.5}  # p_star; printed as 0.007 and 0.353


def near(a: float, b: float) -> bool:
    """Tell whether two pressures or ratios are the same but for rounding."""
    return abs(a - b) <= 1e-6 * abs(b)


def where(rows: Rows, **columns: Any) -> Rows:
    """Choose the rows whose columns have these values."""
    return [row for row in rows if all(row[name] == value for name, value in columns.items())]


def groups(rows: Rows, *columns: str) -> dict[Any, Rows]:
    """Sort rows by the values of a column (of several: by tuples): {value: rows}."""
    of = itemgetter(*columns)
    return {key: list(part) for key, part in groupby(sorted(rows, key=of), of)}


def at_load(rows: Rows, p_star: float) -> Rows:
    """Choose the rows at a pressure."""
    return [row for row in rows if near(row["p_star"], p_star)]


def low_high(rows: Rows) -> dict[str, Rows]:
    """Choose the rows at the two pressures of the paper."""
    return {name: at_load(rows, p) for name, p in PRESSURES.items()}


def by_hurst(rows: Rows) -> dict[float, Rows]:
    """Sort rows by H."""
    return groups(rows, "hurst")


def families(rows: Rows) -> Iterator[tuple[str, float, Rows]]:
    """Yield (name of the pressure, H, rows) for both pressures of the paper and every H."""
    for pressure, part in low_high(rows).items():
        for hurst, family in by_hurst(part).items():
            yield pressure, hurst, family


def finest(rows: Rows, ratio: str) -> Any:
    """Choose the row with the smallest value of eps_c, eps_f or eps_t; None of no rows."""
    return min(rows, key=itemgetter(ratio), default=None)


def coarsest(rows: Rows, ratio: str) -> Any:
    """Choose the row with the largest value of a ratio; None of no rows."""
    return max(rows, key=itemgetter(ratio), default=None)


def longest(rows: Rows, ratio: str, column: str = "lam_l_over_lam_s") -> Rows:
    """Choose the rows that share the value of `column` which has most values of `ratio`."""
    series = {row[column]: where(rows, **{column: row[column]}) for row in rows}
    return max(series.values(), key=lambda part: len({row[ratio] for row in part}), default=[])


def fine_half(rows: Rows) -> Rows:
    """Choose the finer half of the eps_f, where the paper's power laws are meant to hold."""
    octaves = sorted({row["eps_f"] for row in rows})
    return [row for row in rows if row["eps_f"] <= octaves[len(octaves) // 2]] if octaves else []


def quoted(value: Any, sigma: float | None = None) -> str:
    """Write a number with its uncertainty in two digits, "2.060 ± 0.012"; "-" for None."""
    if value is None:
        return "-"
    if not sigma or not sigma > 0:
        return f"{value:.3g}"
    places = max(0, 1 - int(f"{sigma:e}".rpartition("e")[2]))
    if places < 8:
        return f"{value:.{places}f} ± {sigma:.{places}f}"
    return f"{value:.3g} ± {sigma:.2g}"


class _Filled(Formatter):
    def get_field(self, name: str, args: Any, row: Any) -> Any:
        return (name, row), name

    def format_field(self, value: Any, spec: str) -> str:
        name, row = value
        if name not in row:
            return ""
        number = row[name]
        if spec == "±":
            return quoted(number, row.get(f"{name}_se"))
        if number is None:
            return "-"
        return f"1/{1 / number:g}" if spec == "1/" else format(number, spec)


def filled(template: str, row: dict) -> str:
    """Fill a template with the columns of a row.

    `{kappa:.3g}` as str.format; `{kappa:±}` with its standard error, column kappa_se; `{eps_f:1/}`
    its inverse, "1/16". "-" for None, nothing for a column that is not there.
    """
    return _Filled().vformat(template, (), row)


def each(template: str, rows: Rows, separator: str = ", ") -> str:
    """Fill a template with every row, in one line."""
    return separator.join(filled(template, row) for row in rows)


def saying(paper: str, ours: str, why: str = "", **row: Any) -> dict:
    """Make a line "paper says / we find / why", its parts filled with the columns of a row."""
    return {k: filled(v, row) for k, v in (("paper", paper), ("ours", ours), ("why", why))}


def table(rows: Rows, columns: dict[str, str]) -> str:
    """Write a Markdown table; columns: {title: template of its cells}. A long cell goes on in the
    lines below, from one of its commas or semicolons on."""
    lines = [list(columns), ["---"] * len(columns)]
    for row in rows:
        cells = [filled(cell, row) for cell in columns.values()]
        cells = [cell.replace("|", "\\|").replace("*", "\\*") for cell in cells]
        lines += map(list, zip_longest(*map(_broken, cells), fillvalue=""))
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _broken(cell):
    # it breaks after a comma and the like that is not in brackets
    glued = re.sub(r" (?=[^()]*\))|(?<![,;:.]) ", "\0", cell)
    parts = textwrap.wrap(glued, CELL, break_long_words=False, break_on_hyphens=False)
    return [part.replace("\0", " ") for part in parts] or [""]


def as_csv(rows: Rows) -> str:
    """Write rows as CSV; nothing where a row lacks a column."""
    text = io.StringIO()
    columns = dict.fromkeys(name for row in rows for name in row)
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def read_csv(text: str) -> Rows:
    """Read what as_csv wrote; an empty cell is None."""
    return [
        {name: _value(cell) for name, cell in row.items()}
        for row in csv.DictReader(io.StringIO(text))
    ]


def _value(cell):
    for of in (int, float):
        with suppress(ValueError):
            return of(cell)
    return {"True": True, "False": False, "": None}.get(cell, cell)
