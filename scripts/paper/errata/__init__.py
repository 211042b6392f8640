"""The errata of the paper: what is printed, what is right, and a function that shows it."""

from typing import Any

from ..rows import Rows
from . import area, formulas, gap

ERRATA = (*formulas.ERRATA, *area.ERRATA, *gap.ERRATA)


def errata_rows(tables: dict[str, Rows]) -> Rows:
    """List the errata that {study: rows} show, numbered."""
    rows: Rows = []
    for printed, right, show in ERRATA:
        try:
            shown: Any = show(tables)
        except (ValueError, TypeError, IndexError):
            if all(tables.values()):
                raise
            continue  # some study has no rows yet
        if shown:
            number = len(rows) + 1
            rows.append({"number": number, "printed": printed, "right": right, "shown": shown})
    return rows
