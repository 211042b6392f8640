"""Tables in pages are what the measured rows give, and every picture is there with a caption."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS))
import _tables  # noqa: E402

WRITTEN = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "slurm/README.md")),
    ROOT / "packaging/README.md",
    *(p for p in DOCS.rglob("*.md") if not {"study", "generated", "_build"} & set(p.parts)),
]
STUDY = sorted((DOCS / "study").glob("*.md"))
PICTURE = re.compile(r"^!\[[^\]]*\]\(([^)]+)\)\n\n(.*?)(?:\n\n|\Z)", re.MULTILINE | re.DOTALL)


def name(path):
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", _tables.PAGES, ids=name)
def test_tables_are_what_the_rows_give(path):
    text = path.read_text(encoding="utf-8")
    assert text == _tables.filled(text)


@pytest.mark.parametrize("path", [*WRITTEN, *STUDY], ids=name)
def test_each_picture_says_what_it_shows(path):
    text = path.read_text(encoding="utf-8")
    found = PICTURE.findall(text)
    assert len(found) == text.count("![")
    for picture, caption in found:
        assert (path.parent / picture).is_file()
        assert re.fullmatch(r"\*(?!\*).{20,}\*", caption, re.DOTALL), picture
