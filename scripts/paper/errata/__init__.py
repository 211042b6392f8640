"""The errata of the paper (errata.toml), each shown by a function of its name here.

It takes {item: rows} and says how our numbers show the erratum, "" while they do not reach so far.
"""

import tomllib
from pathlib import Path

from ..rows import Rows
from . import area, formulas, gap

ERRATA = tomllib.loads(Path(__file__).parents[1].joinpath("errata.toml").read_text("utf-8"))
SHOWS = {**vars(formulas), **vars(area), **vars(gap)}


def errata_rows(tables: dict[str, Rows]) -> Rows:
    """List the errata that {item: rows} show, numbered."""
    rows: Rows = []
    for name, texts in ERRATA.items():
        try:
            shown = SHOWS[name](tables)
        except (ValueError, TypeError, IndexError):
            if all(tables.values()):
                raise
            continue  # some item has no rows yet
        if shown:
            rows.append(texts | {"number": len(rows) + 1, "shown": shown})
    return rows
