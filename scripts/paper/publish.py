"""What is stored of a study as a table (CSV, JSON) and a picture (PNG) beside the runs; of one
beyond the paper also as a page: what is asked, picture, what we find, numbers, command, time
(Markdown)."""

import csv
import io
import json
from pathlib import Path
from typing import Any

from hpc_gfmd import __version__
from hpc_gfmd.util.atomic import aside

from .catalogue import Study
from .rows import Rows
from .store import Store
from .text import literal, table

PAGE = """# {title}

{question}

![{title}]({name}.png)

{found}

{numbers}

All numbers: [{name}.csv]({name}.csv), [{name}.json]({name}.json). "±" is one standard error.

Made by `python scripts/paper {name} --level {level}` (hpc_gfmd {version}): {loads} loads on {surfaces} surfaces, grids from {low}² to {high}²
points, {minutes:.0f} minutes of solving in all, on one shared core; {poor} loads failed their accuracy of {accuracy:g}.
"""


def publish(study: Study, store: Store, level: str) -> Rows:
    """Write NAME.csv, NAME.json, NAME.png and, of a study beyond the paper, NAME.md into the folder
    of the store; returns the rows.

    Nothing stored of it: nothing is written and the rows are empty.
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


def page(study: Study, rows: Rows, runs: Rows, level: str) -> str:
    """The text; runs: those that the rows are made of."""
    found = "\n".join(
        f"- {literal(line['paper'])}: **{literal(line['ours'])}**"
        + (f" ({literal(line['why'])})" if line["why"] else "")
        for line in study.compare(rows)
    )
    surfaces = {(run["hurst"], run["seed"], run["eps_t"], run["eps_f"]) for run in runs}
    return PAGE.format(
        name=study.name,
        title=study.title,
        question=study.question,
        found=found,
        level=level,
        version=__version__,
        numbers=table(study.lines(rows), study.columns),
        surfaces=len(surfaces),
        **effort(runs),
    )


def effort(runs: Rows) -> dict[str, Any]:
    """What runs took: loads, low and high (points along an axis), minutes, poor (loads that failed
    their accuracy), accuracy."""
    sizes = [run["n"] for run in runs] or [0]
    return {
        "loads": len(runs),
        "low": min(sizes),
        "high": max(sizes),
        "minutes": sum(run["wall_seconds"] for run in runs) / 60,
        "poor": sum(run["status"] != "converged" for run in runs),
        "accuracy": max((run["accuracy"] for run in runs), default=0),
    }


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
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
        for line in cells
    )


def write_whole(path: str | Path, text: str) -> None:
    """Write a file so that it is there complete or not at all. Raises OSError."""
    with aside(Path(path)) as tmp:
        tmp.write_text(text, encoding="utf-8")


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.5g}" if isinstance(value, float) else str(value)
