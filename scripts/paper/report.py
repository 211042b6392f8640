"""Tables (CSV), pictures (PNG) and pages (Markdown) beside the runs, and the report of all items.

All numbers come from the rows of the items or from small computations made for the report, those of
the paper from paper_numbers.json and its coefficient tables.
"""

import json
import os
from pathlib import Path

from .cases import Store, cases_of
from .errata import errata_rows
from .items import TEXTS
from .items.tables import our_table
from .rows import Rows, as_csv, table
from .study import Study

TITLES = {"paper": "claim", "ours": "we find", "why": "remark"}  # of columns of a comparison
PAGE = """# {title}

{about}

![{title}]({name}.png)

*{caption}*

{comparisons}

All numbers: [{name}.csv]({name}.csv); ± is one standard error. Made by `python scripts/paper {name} --level {level}`.
"""
ERRATA = """# Errata of the paper

What is printed, what is right, and what shows it: a small computation, or the runs of the figures.

{errata}

Made by `python scripts/paper all`.
"""
HEAD = """# The paper, reproduced, checked and extended

N. Prodanov, W. B. Dapp, M. H. Müser, *On the contact area and mean gap of rough, elastic contacts*, Tribol. Lett. 53 (2014) 433,
[doi:10.1007/s11249-013-0282-z](https://doi.org/10.1007/s11249-013-0282-z): every figure and table, and its [errata](errata.md).

{loads} loads, {minutes:.0f} minutes of solving, accuracy {accuracy:g}; {poor} failed it.
All numbers follow from the runs kept in this folder: `python scripts/paper all --level {level} -o FOLDER`.

- "As counted": grid points in contact. "Edge-corrected": less (π - 1 + ln 2)/24 of a point for every segment of the contact
  boundary (Yastrebov, Anciaux, Molinari 2017).
- "±": one standard error, from the scatter of realisations and a fifth of the solver's error estimate. Runs of one surface on
  several grids are compared surface by surface.
- Theory: Persson with gamma = 0.42, never scaled.

{items}
"""


def publish(study: Study, store: Store, level: str) -> Rows:
    """Write table, picture and page of an item from its stored runs; return the rows of the table.

    There are none if nothing is stored.
    """
    path = store.folder / study.name
    runs = store.runs_of(cases_of(study.name, level))
    rows = study.tabulate(runs, level) if runs else []
    if rows:
        write_whole(path.with_suffix(".csv"), as_csv(rows))
        study.draw(rows, path.with_suffix(".png"))
        write_whole(path.with_suffix(".md"), _page(study, rows, level))
    return rows


def _page(study, rows, level):
    text = TEXTS[study.name]
    lines = list(study.compare(rows))
    columns = {
        title: f"{{{key}}}" for key, title in TITLES.items() if any(line[key] for line in lines)
    }
    about = text.get("question") or f"The paper: {text['paper']}."
    comparisons = table(lines, columns) if lines else ""
    return PAGE.format(**text, name=study.name, about=about, comparisons=comparisons, level=level)


def report(store: Store, level: str, tables: dict[str, Rows]) -> Path:
    """Write README.md, which links the pages of all items, and errata.md, with the {item: rows} of
    the items of the paper. Return the path of README.md."""
    runs = list(store.stored().values())
    items = [
        text | {"link": f"[{name}]({name}.md)" if (store.folder / f"{name}.md").is_file() else name}
        for name, text in TEXTS.items()
    ]
    head = HEAD.format(
        level=level,
        loads=len(runs),
        minutes=sum(run["wall_seconds"] for run in runs) / 60,
        accuracy=max((run["accuracy"] for run in runs), default=0),
        poor=sum(run["status"] != "converged" for run in runs),
        items=table(items, {"page": "{link}", "what": "{title}", "paper, literature": "{paper}"}),
    )
    path = store.folder / "README.md"
    write_whole(path, head)
    columns = {"": "{number}", "printed": "{printed}", "right": "{right}", "shown by": "{shown}"}
    errata = ERRATA.format(errata=table(errata_rows(tables), columns))
    write_whole(path.with_name("errata.md"), errata)
    return path


def coefficients(store: Store, level: str) -> str:
    """Return our table of coefficients, for `hpc-gfmd tfc --table`, as JSON."""
    tables = our_table(store.runs_of(cases_of("table5", level)), level)
    return json.dumps(tables, indent=1, allow_nan=False) + "\n"


def write_whole(path: Path, text: str) -> None:
    """Write a file atomically: it is complete or unchanged. Raises OSError."""
    part = path.with_name(f".{path.name}.part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)
