"""Pages are short, in the present tense, with no sentence or table cell that loses its reader."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MADE = ("docs/study", "docs/generated", "docs/_build", "docs/slurm", "docs/billion")
PAGES = [
    path
    for path in (ROOT / "README.md", ROOT / "slurm/README.md", *ROOT.glob("docs/**/*.md"))
    if not str(path.relative_to(ROOT)).startswith(MADE)
]
CODE = re.compile(r"```.*?```|^    [^\n]*$|\$\$.*?\$\$|`[^`]*`", re.DOTALL | re.MULTILINE)
TABLE = re.compile(r"^\|[^\n]*$", re.MULTILINE)
HISTORY = re.compile(r"\b\d\d:\d\d\b|the code of|\bolder\b|code before|as before\b")


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_reader_gets_to_the_end(path):
    text = path.read_text(encoding="utf-8")
    assert len(text.split()) <= 2000
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", CODE.sub("x", text))
    assert HISTORY.findall(plain) == []
    cells = [cell.strip() for row in TABLE.findall(plain) for cell in row.split("|")]
    assert [cell for cell in cells if len(cell) > 120] == []
    paragraphs = re.split(r"\n\s*\n|\n(?=[-*#]|\d\.)", TABLE.sub("", plain))
    sentences = [
        s for text in paragraphs for s in re.split(r"(?<=[.!?:])\s", " ".join(text.split()))
    ]
    assert [sentence for sentence in sentences if len(sentence.split()) > 30] == []


def test_together():
    """Words of all pages; bytes of pages and pictures."""
    assert sum(len(path.read_text(encoding="utf-8").split()) for path in PAGES) < 26_000
    files = [path for path in (ROOT / "docs").rglob("*") if path.is_file()]
    kept = [path for path in files if not {"_build", "generated"} & set(path.parts)]
    assert sum(path.stat().st_size for path in kept) < 5_000_000
