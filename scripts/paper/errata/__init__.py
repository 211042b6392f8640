"""The errata of the paper.

errata.toml lists them. A function of the same name in a file of this folder takes {item: rows} and
returns a text that shows the erratum with our numbers, or "" if they do not suffice.
"""

import tomllib
from pathlib import Path

from ..rows import Rows
from . import area, formulas, gap

ERRATA = tomllib.loads(Path(__file__).parents[1].joinpath("errata.toml").read_text("utf-8"))
SHOWS = {**vars(formulas), **vars(area), **vars(gap)}


def errata_rows(tables: dict[str, Rows]) -> Rows:
    """Return the errata that can be shown with the rows of the items, {item: rows}, numbered."""
    rows: Rows = []
    for name, texts in ERRATA.items():
        try:
            shown = SHOWS[name](tables)
        except (ValueError, TypeError, IndexError):
            if all(tables.values()):
                raise
            continue  # an item has no rows yet
        if shown:
            rows.append(texts | {"number": len(rows) + 1, "shown": shown})
    return rows
