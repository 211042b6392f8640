"""Choosing among rows, which are dicts: by what columns have, by pressure, by H, along a ratio."""

from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter
from typing import Any

from .levels import PRESSURES

Rows = list[dict]


def near(a: float, b: float) -> bool:
    """Whether two pressures or ratios are the same but for rounding."""
    return abs(a - b) <= 1e-6 * abs(b)


def where(rows: Rows, **columns: Any) -> Rows:
    """The rows whose columns have these values."""
    return [row for row in rows if all(row[name] == value for name, value in columns.items())]


def groups(rows: Rows, *columns: str) -> dict[Any, Rows]:
    """{value: rows that have it in a column}, of several columns {values: rows}, sorted by the
    values; rows keep their order."""
    of = itemgetter(*columns)
    return {key: list(part) for key, part in groupby(sorted(rows, key=of), of)}


def at_load(rows: Rows, p_star: float) -> Rows:
    """The rows (or runs) at a pressure."""
    return [row for row in rows if near(row["p_star"], p_star)]


def low_high(rows: Rows) -> dict[str, Rows]:
    """The rows (or runs) at the two pressures of the paper, {"low": [...], "high": [...]}."""
    return {name: at_load(rows, p) for name, p in PRESSURES.items()}


def by_hurst(rows: Rows) -> dict[float, Rows]:
    """{H: rows}, in the order of H."""
    return groups(rows, "hurst")


def families(rows: Rows) -> Iterator[tuple[str, float, Rows]]:
    """(name of the pressure, H, rows) for both pressures of the paper, the low one first, and every
    H that has rows there."""
    for pressure, part in low_high(rows).items():
        for hurst, family in by_hurst(part).items():
            yield pressure, hurst, family


def finest(rows: Rows, ratio: str) -> Any:
    """The row with the smallest value of eps_c, eps_f or eps_t; None of no rows."""
    return min(rows, key=itemgetter(ratio), default=None)


def coarsest(rows: Rows, ratio: str) -> Any:
    """The row with the largest value of a ratio; None of no rows."""
    return max(rows, key=itemgetter(ratio), default=None)


def longest(rows: Rows, ratio: str, column: str = "lam_l_over_lam_s") -> Rows:
    """Of the series of rows that share a value of `column`, the one with most values of `ratio`; []
    of no rows."""
    series = {row[column]: where(rows, **{column: row[column]}) for row in rows}
    return max(series.values(), key=lambda part: len({row[ratio] for row in part}), default=[])


def fine_half(rows: Rows) -> Rows:
    """Rows of the finer half of the eps_f, where the paper's power laws are meant to hold."""
    octaves = sorted({row["eps_f"] for row in rows})
    return [row for row in rows if row["eps_f"] <= octaves[len(octaves) // 2]] if octaves else []
