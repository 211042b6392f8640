"""The report: every figure and table with what the paper says beside it, the open questions, the
errata. Markdown.

All numbers come from the rows of the studies, or from small computations made while the report is
written; those of the paper from paper_numbers.json and its coefficient tables.
"""

import json
from pathlib import Path
from typing import Any

from hpc_gfmd import __version__

from . import catalogue, coefficients, questions
from .catalogue import Study
from .errata import area, formulas, gap
from .levels import tfc_series
from .publish import effort, publish, write_whole
from .rows import Rows
from .store import Store
from .text import literal, table

FILE, OUR_TABLE = "README.md", "our_tfc.json"
ERRATA = (*formulas.ERRATA, *area.ERRATA, *gap.ERRATA)
HEAD = """# The paper, reproduced, checked and extended

N. Prodanov, W. B. Dapp, M. H. Müser, *On the contact area and mean gap of rough, elastic contacts*, Tribology Letters 53 (2014) 433:
every figure and table, made by `python scripts/paper all --level {level}` (hpc_gfmd {version}). All numbers below are computed from the runs
in `runs*.jsonl` when this page is written; nothing is typed in.

{loads} loads on grids from {low}² to {high}² points, {minutes:.0f} minutes of solving in all, accuracy {accuracy:g}; {poor} failed it.

- a_r and kappa "as counted": grid points in contact (filled marks); "edge-corrected": less (π - 1 + ln 2)/24 of a point for every
  segment of the contact boundary (open marks; Yastrebov, Anciaux, Molinari 2017).
- "±": one standard error, from the scatter of realisations and a fifth of the solver's error estimate. Runs of one surface on several
  grids are compared surface by surface.
- Theory: Persson with gamma = 0.42, corrected (solid) and as printed (dashed), never scaled."""


def report(folder: str | Path, level: str) -> Path:
    """Write README.md and our_tfc.json beside the tables and pictures of a folder of runs, which
    are made where missing or old.

    Returns the path of the report. Raises OSError, SceneError for a level that does not exist.
    """
    store = Store(folder)
    store.folder.mkdir(parents=True, exist_ok=True)
    runs = store.load()
    studies = [catalogue.study(name) for name in catalogue.of_paper()]
    tables = {study.name: _rows(study, store, level) for study in studies}
    lines = {
        study.name: list(study.compare(tables[study.name])) if tables[study.name] else []
        for study in studies
    }
    series = store.runs_of(tfc_series(level))
    ours = coefficients.our_table(series, level)
    if ours["tables"]:
        coefficients.write_our_table(ours, store.folder / OUR_TABLE)
    parts = [
        HEAD.format(version=__version__, level=level, **effort(runs)),
        _beyond(store),
        questions.section(series, tables, level),
        _figures(studies, tables, lines, store),
        _says(lines),
        _errata(tables),
    ]
    path = store.folder / FILE
    write_whole(path, "\n\n".join(part for part in parts if part) + "\n")
    return path


def _rows(study: Study, store: Store, level: str) -> Rows:
    """The rows that were published for exactly these runs, or published now."""
    path = store.folder / f"{study.name}.json"
    picture = path.with_suffix(".png")
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        if (
            found["level"] == level
            and found["runs"] == len(store.runs_of(study.cases(level)))
            and picture.is_file()
        ):
            return found["rows"]
    except (OSError, ValueError, KeyError):
        pass
    return publish(study, store, level)


def _beyond(store: Store) -> Any:
    pages = [name for name in catalogue.names() if (store.folder / f"{name}.md").is_file()]
    links = ", ".join(f"[{catalogue.study(name).title}]({name}.md)" for name in pages)
    return (
        pages
        and f"Beyond the paper: {links}. What `runs*.jsonl` lacks of their runs the command of each page solves anew."
    )


def _figures(
    studies: list[Study], tables: dict[str, Rows], lines: dict[str, Rows], store: Store
) -> str:
    parts = ["## Figures and tables"]
    if (store.folder / OUR_TABLE).is_file():
        parts.append(
            "Our coefficients with their covariances, for `hpc-gfmd tfc --table`:"
            f" [{OUR_TABLE}]({OUR_TABLE})."
        )
    for study in studies:
        rows = tables[study.name]
        parts.append(f"### {study.name}: {study.title}\n\nPaper: {study.paper}.")
        if not rows:
            parts.append("Nothing solved yet.")
            continue
        if (store.folder / f"{study.name}.png").is_file():
            parts.append(f"![{study.title}]({study.name}.png)")
        parts.append(
            f"Numbers: [{study.name}.csv]({study.name}.csv),"
            f" [{study.name}.json]({study.name}.json)."
        )
        if said := lines[study.name]:
            parts.append(
                "\n".join(
                    f"- paper: {literal(line['paper'])}; we find: **{literal(line['ours'])}**"
                    for line in said
                )
            )
    return "\n\n".join(parts)


def _says(lines: dict[str, Rows]) -> str:
    rows = [{"study": name} | line for name, said in lines.items() for line in said]
    columns = {"where": "{study}", "paper says": "{paper}", "we find": "{ours}", "why": "{why}"}
    return "## Paper says / we find / why\n\n" + table(rows, columns)


def _errata(tables: dict[str, Rows]) -> str:
    rows = [row for erratum in ERRATA if (row := erratum.row(tables))]
    columns = {"": "{number}", "printed": "{printed}", "right": "{right}", "shown by": "{shown}"}
    return "## Errata of the paper\n\n" + table(
        [{"number": i + 1} | row for i, row in enumerate(rows)], columns
    )
