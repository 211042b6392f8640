"""Tables (CSV), pictures (PNG) and pages (Markdown) beside the runs, and the report of all items.

All numbers come from the rows of the items, or from small computations made while the report is
written; those of the paper from paper_numbers.json and its coefficient tables.
"""

import json
import os
from pathlib import Path

from .cases import Store, cases_of
from .errata import errata_rows
from .items import STUDIES, TEXTS
from .items.tables import our_table
from .rows import Rows, as_csv, read_csv, table
from .study import Study

SAYS = {"paper says": "{paper}", "we find": "{ours}", "why": "{why}"}
MADE = "Made by `python scripts/paper {name} --level {level}`."
PAGE = """# {title}

{question}

![{title}]({name}.png)

{found}

All numbers: [{name}.csv]({name}.csv); ± is one standard error. {made}
"""
HEAD = """# The paper, reproduced, checked and extended

N. Prodanov, W. B. Dapp, M. H. Müser, *On the contact area and mean gap of rough, elastic contacts*, Tribology Letters 53 (2014) 433:
every figure and table. {made} All numbers are computed from the runs in `runs*.jsonl` when this page is written.

{loads} loads on grids from {low}² to {high}² points, {minutes:.0f} minutes of solving, accuracy {accuracy:g}; {poor} failed it.

- "As counted": grid points in contact (filled marks). "Edge-corrected": less (π - 1 + ln 2)/24 of a point for every segment of the
  contact boundary (open marks; Yastrebov, Anciaux, Molinari 2017).
- "±": one standard error, from the scatter of realisations and a fifth of the solver's error estimate. Runs of one surface on several
  grids are compared surface by surface.
- Theory: Persson with gamma = 0.42, corrected (solid) and as printed (dashed), never scaled."""


def rows_of(study: Study, store: Store, level: str, redraw: bool = False) -> Rows:
    """Tabulate what is stored; redraw: read the table that is there."""
    if redraw:
        return read_csv((store.folder / f"{study.name}.csv").read_text(encoding="utf-8"))
    runs = store.runs_of(cases_of(study.name, level))
    return study.tabulate(runs, level) if runs else []


def publish(study: Study, store: Store, level: str, redraw: bool = False) -> Rows:
    """Write table, picture and, of an item beyond the paper, page; returns the rows, [] of none."""
    if rows := rows_of(study, store, level, redraw):
        path = store.folder / study.name
        if not redraw:
            write_whole(path.with_suffix(".csv"), as_csv(rows))
        study.draw(rows, path.with_suffix(".png"))
        if "question" in TEXTS[study.name]:
            write_whole(path.with_suffix(".md"), _page(study, rows, level))
    return rows


def _page(study, rows, level):
    columns = {"": "{paper}", "we find": "{ours}", " ": "{why}"}
    lines = list(study.compare(rows))
    if not any(line["why"] for line in lines):
        del columns[" "]
    return PAGE.format(
        name=study.name,
        **TEXTS[study.name],
        found=table(lines, columns),
        made=MADE.format(name=study.name, level=level),
    )


def report(store: Store, level: str, tables: dict[str, Rows]) -> Path:
    """Write README.md of all figures and tables, {item: rows}; returns its path."""
    runs = list(store.stored().values())
    sizes = [run["n"] for run in runs] or [0]
    parts = [
        HEAD.format(
            made=MADE.format(name="all", level=level),
            loads=len(runs),
            low=min(sizes),
            high=max(sizes),
            minutes=sum(run["wall_seconds"] for run in runs) / 60,
            accuracy=max((run["accuracy"] for run in runs), default=0),
            poor=sum(run["status"] != "converged" for run in runs),
        )
    ]
    beyond = [name for name in TEXTS if (store.folder / f"{name}.md").is_file()]
    if beyond:
        links = ", ".join(f"[{TEXTS[name]['title']}]({name}.md)" for name in beyond)
        parts.append(f"Beyond the paper: {links}. Their commands solve what `runs*.jsonl` lacks.")
    for name, rows in tables.items():
        title = TEXTS[name]["title"]
        parts.append(f"## {name}: {title}\n\nPaper: {TEXTS[name]['paper']}.")
        if not rows:
            parts.append("Nothing solved yet.")
            continue
        parts.append(f"![{title}]({name}.png)\n\nNumbers: [{name}.csv]({name}.csv).")
        if lines := list(STUDIES[name].compare(rows)):
            parts.append(table(lines, SAYS))
    columns = {"": "{number}", "printed": "{printed}", "right": "{right}", "shown by": "{shown}"}
    parts.append("## Errata of the paper\n\n" + table(errata_rows(tables), columns))
    path = store.folder / "README.md"
    write_whole(path, "\n\n".join(parts) + "\n")
    return path


def coefficients(store: Store, level: str) -> str:
    """Write our table of coefficients, for `hpc-gfmd tfc --table`, as JSON."""
    found = our_table(store.runs_of(cases_of("table5", level)), level)
    return json.dumps(found, indent=1, allow_nan=False) + "\n"


def write_whole(path: Path, text: str) -> None:
    """Write a file so that it is there complete or not at all. Raises OSError."""
    part = path.with_name(f".{path.name}.part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)
