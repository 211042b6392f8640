"""Rows, which are dicts: functions that choose among them and write them as text."""

import csv
import io
from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter
from string import Formatter
from typing import Any

Rows = list[dict]
PRESSURES = {"low": 0.01 / 2**0.5, "high": 0.5 / 2**0.5}  # p_star; printed as 0.007 and 0.353


def near(a: float, b: float) -> bool:
    """Return whether two pressures or ratios are equal except for rounding."""
    return abs(a - b) <= 1e-6 * abs(b)


def where(rows: Rows, **columns: Any) -> Rows:
    """Return the rows whose columns have these values."""
    return [row for row in rows if all(row[name] == value for name, value in columns.items())]


def groups(rows: Rows, *columns: str) -> dict[Any, Rows]:
    """Return {value: rows} by the values of a column, or by tuples of those of several columns."""
    value_of = itemgetter(*columns)
    ordered = sorted(rows, key=value_of)
    return {value: list(members) for value, members in groupby(ordered, value_of)}


def at_load(rows: Rows, p_star: float) -> Rows:
    """Return the rows at a pressure."""
    return [row for row in rows if near(row["p_star"], p_star)]


def low_high(rows: Rows) -> dict[str, Rows]:
    """Return the rows at the two pressures of the paper: {"low": rows, "high": rows}."""
    return {name: at_load(rows, p) for name, p in PRESSURES.items()}


def by_hurst(rows: Rows) -> dict[float, Rows]:
    """Return {H: rows}."""
    return groups(rows, "hurst")


def families(rows: Rows) -> Iterator[tuple[str, float, Rows]]:
    """Yield (name of the pressure, H, rows) for both pressures of the paper and every H."""
    for pressure, rows_at_pressure in low_high(rows).items():
        for hurst, family in by_hurst(rows_at_pressure).items():
            yield pressure, hurst, family


def finest(rows: Rows, ratio: str) -> Any:
    """Return the row with the smallest eps_c, eps_f or eps_t; None without rows."""
    return min(rows, key=itemgetter(ratio), default=None)


def coarsest(rows: Rows, ratio: str) -> Any:
    """Return the row with the largest eps_c, eps_f or eps_t; None without rows."""
    return max(rows, key=itemgetter(ratio), default=None)


def longest(rows: Rows, ratio: str, column: str = "lam_l_over_lam_s") -> Rows:
    """Return the series with most different values along a ratio; the rows of a series share the
    value of a column."""
    series = {row[column]: where(rows, **{column: row[column]}) for row in rows}
    return max(series.values(), key=lambda part: len({row[ratio] for row in part}), default=[])


def fine_half(rows: Rows) -> Rows:
    """Return the rows of the finer half of the eps_f, where the paper's power laws should hold."""
    octaves = sorted({row["eps_f"] for row in rows})
    return [row for row in rows if row["eps_f"] <= octaves[len(octaves) // 2]] if octaves else []


def quoted(value: Any, sigma: float | None = None) -> str:
    """Return a number with its standard error in two digits, "2.060 ± 0.012"; "-" for None."""
    if value is None:
        return "-"
    if not sigma or not sigma > 0:
        return f"{value:.3g}"
    places = max(0, 1 - int(f"{sigma:e}".rpartition("e")[2]))
    if places < 8:
        return f"{value:.{places}f} ± {sigma:.{places}f}"
    return f"{value:.3g} ± {sigma:.2g}"


class _RowFormatter(Formatter):
    """Formats the templates of `filled`: fields are (name, row)."""

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
    """Return a template filled with the columns of a row.

    `{kappa:.3g}` is as in str.format, `{kappa:±}` appends the standard error (column kappa_se),
    `{eps_f:1/}` is the inverse, "1/16". None becomes "-", a missing column the empty string.
    """
    return _RowFormatter().vformat(template, (), row)


def filled_with_each(template: str, rows: Rows, separator: str = ", ") -> str:
    """Return a template filled with every row (`filled`), joined in one line."""
    return separator.join(filled(template, row) for row in rows)


def comparison(paper: str, ours: str, why: str = "", **row: Any) -> dict:
    """Return a line "claim / we find / remark" of a page from templates (see `filled`) and the
    columns that fill them."""
    return {"paper": filled(paper, row), "ours": filled(ours, row), "why": filled(why, row)}


def table(rows: Rows, columns: dict[str, str]) -> str:
    """Return a Markdown table with columns {title: template of the cells}."""
    lines = [list(columns), ["---"] * len(columns)]
    for row in rows:
        cells = [filled(cell, row) for cell in columns.values()]
        lines.append([cell.replace("|", "\\|").replace("*", "\\*") for cell in cells])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def as_csv(rows: Rows) -> str:
    """Return rows as CSV; a cell is empty where a row lacks the column."""
    text = io.StringIO()
    columns = dict.fromkeys(name for row in rows for name in row)
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
