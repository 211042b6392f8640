"""Pages are short, in the present tense, with no sentence or table cell that loses its reader; what
is measured in them is what the rows say."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS))
import _pages  # noqa: E402
import _tables  # noqa: E402

WRITTEN = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "slurm/README.md")),
    ROOT / "packaging/README.md",
    *(p for p in DOCS.rglob("*.md") if not {"study", "generated", "_build"} & set(p.parts)),
]
STUDY = sorted((DOCS / "study").glob("*.md"))
CHANGES = ROOT / "CHANGELOG.md"
CODE = re.compile(r"```.*?```|\$\$.*?\$\$|`[^`]*`|<!--.*?-->|\$[^$\n]*\$", re.DOTALL)
BLOCK = re.compile(r"```[a-z]*\n(.*?)```", re.DOTALL)
TABLE = re.compile(r"^\|[^\n]*$", re.MULTILINE)
PICTURE = re.compile(r"^!\[[^\]]*\]\(([^)]+)\)\n\n(.*?)(?:\n\n|\Z)", re.MULTILINE | re.DOTALL)
HISTORY = re.compile(r"\b\d\d:\d\d\b|the code of|\b(?:older|before|formerly|no longer)\b", re.I)


def plain(text):
    """A page without code, formulas and the addresses of its links."""
    return re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", CODE.sub("x", text))


def cells(text):
    return [cell.strip() for row in TABLE.findall(text) for cell in re.split(r"(?<!\\)\|", row)]


def sentences(text):
    parts = re.split(r"\n\s*\n|\n(?=\s*(?:[-*] |#|\d+\. ))", TABLE.sub("", text))
    return [s for part in parts for s in re.split(r"(?<=[.!?])\s", " ".join(part.split()))]


def assert_short(said):
    """All cells of tables and all sentences are."""
    assert [cell for cell in cells(said) if len(cell) > 120] == []
    assert [sentence for sentence in sentences(said) if len(sentence.split()) > 30] == []


def written(path):
    """The words of a page, but for tables that are made of measured rows."""
    return _tables.PLACE.sub("", path.read_text(encoding="utf-8")).split()


def name(path):
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", [*WRITTEN, *STUDY, CHANGES], ids=name)
def test_a_reader_gets_to_the_end(path):
    text = path.read_text(encoding="utf-8")
    assert len(written(path)) <= 2500
    said = plain(text)
    assert_short(said)
    assert path == CHANGES or HISTORY.findall(said) == []
    lines = [line for block in BLOCK.findall(text) for line in block.splitlines()]
    assert [line for line in lines if len(line) > 100] == []


@pytest.mark.parametrize("page", ["scene", "observables", "gallery"])
def test_the_reference_reads_as_well(page):
    assert_short(plain(_pages.made()[page]))


@pytest.mark.parametrize("path", STUDY, ids=name)
def test_pages_of_the_paper_are_pictures_tables_and_few_words(path):
    assert len(TABLE.sub("", plain(path.read_text(encoding="utf-8"))).split()) <= 150


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


def test_a_release_has_few_changes():
    for release in CHANGES.read_text(encoding="utf-8").split("\n## ")[1:]:
        assert release.count("\n- ") <= 15


def test_together():
    """Words of all pages; bytes of pages and pictures; no file that no page names."""
    assert sum(len(written(path)) for path in WRITTEN) < 26_000
    files = [path for path in DOCS.rglob("*") if path.is_file()]
    kept = [path for path in files if not {"_build", "generated"} & set(path.parts)]
    assert sum(path.stat().st_size for path in kept) < 5_000_000
