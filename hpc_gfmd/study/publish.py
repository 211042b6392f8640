"""What is stored of a study as a table (CSV, JSON) and a picture (PNG) beside the runs."""

import csv
import io
import json
import os
from pathlib import Path
from typing import Any

from .page import page
from .rows import Rows
from .store import Store
from .study import Study


def publish(study: Study, store: Store, level: str) -> Rows:
    """Write NAME.csv, NAME.json, NAME.png and, of a study beyond the paper, NAME.md into the folder of the store; returns the rows.

    study: study.Study. Nothing stored of it: nothing is written and the rows are empty.
    """
    cases = study.cases(level)
    runs = store.runs_of(cases)
    if cases and not runs:
        return []
    rows = study.tabulate(runs, level)
    store.folder.mkdir(parents=True, exist_ok=True)
    path = store.folder / study.name
    head = {"name": study.name, "title": study.title, "level": level, "runs": len(runs)}
    write_whole(path.with_suffix(".csv"), as_csv(rows))
    write_whole(path.with_suffix(".json"), json.dumps(head | {"rows": rows}, indent=1) + "\n")
    study.draw(rows, path.with_suffix(".png"))
    if study.question:
        write_whole(path.with_suffix(".md"), page(study, rows, runs, level))
    return rows


def columns_of(rows: Rows) -> list[str]:
    """Names of all columns, in the order of their first appearance."""
    return list(dict.fromkeys(name for row in rows for name in row))


def as_csv(rows: Rows) -> str:
    """The rows as CSV; nothing where a row lacks a column."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns_of(rows), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def as_text(rows: Rows) -> str:
    """The rows for a terminal, numbers in five digits."""
    columns = columns_of(rows)
    cells = [columns, *([_cell(row.get(name)) for name in columns] for row in rows)]
    widths = [max(len(line[k]) for line in cells) for k in range(len(columns))]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)) for line in cells)


def write_whole(path: str | Path, text: str) -> None:
    """Write a file so that it is there complete or not at all. Raises OSError."""
    aside = Path(path).with_suffix(f".{os.getpid()}.tmp")
    aside.write_text(text, encoding="utf-8")
    os.replace(aside, path)


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.5g}" if isinstance(value, float) else str(value)
