"""The table of faults: `python tests/faults/report.py` makes docs/faults/README.md of docs/faults/faults.jsonl.

The records come from `pytest tests/faults --record-faults` and `pytest -m slow tests/faults --record-faults`.
"""

import json
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "docs" / "faults"
HEAD = """# Faults

Every fault below was provoked for real, by the command in the last column. What happened then is as recorded by the tests
(`pytest tests/faults --record-faults`, and with `-m slow` for the long ones); this page is made of the records by
`python tests/faults/report.py`. "Code" is the exit code of the command that met the fault, "seconds" the time from the fault to the
end of the last process. The commands are run with `scripts/setup`'s `.venv/bin` on the path.

| fault | how it was provoked | code | message | seconds | lost | repeat with |
|---|---|---|---|---|---|---|
"""


def table(lines):
    """The page as Markdown; lines: records as in conftest.py."""
    rows = []
    for line in lines:
        cells = [_cell(line[key]) for key in ("fault", "how", "code", "message", "seconds", "lost")]
        rows.append(f"| {' | '.join(cells)} | `{_cell(line['command'])}` |\n")
    return HEAD + "".join(rows)


def _cell(value):
    return str(value).replace("|", "\\|").replace("\n", " ")


if __name__ == "__main__":
    records = (FOLDER / "faults.jsonl").read_text().splitlines()
    (FOLDER / "README.md").write_text(table([json.loads(text) for text in records]))
