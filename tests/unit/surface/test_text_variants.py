"""Text files of heights in many layouts: read as by NumPy, to the bit, or refused where NumPy would
read something else than was written."""

from io import StringIO
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from contacts import random_heights
from refusal import refused

from hpc_gfmd.scene import File
from hpc_gfmd.surface.topography import open_topography

Z = np.round(20 * random_heights((240, 6)), 4)  # more lines than those that decide the layout
KEYS = {"physical_sizes": (24.0, 0.6)}
EARLY = [(0, 0), (3, 5)]
LATE = [(230, 2), (239, 5)]
HEADS = {
    "none": "",
    "comment": "# heights\n# of a scan\n",
    "words": "Profiler 3, version 2\nranges: a b\n\n",
    "names": None,
    "percent": "% heights in nm\n",
}


def numpy_reads(text, mark, decimal, missing):
    """Heights by numpy.genfromtxt."""
    plain = text.replace(decimal, ".") if decimal == "," else text
    for token in missing:
        plain = plain.replace(token, "nan")
    return np.genfromtxt(StringIO(plain), delimiter=None if mark in (" ", "   ") else mark)


def body(mark, decimal, form, holes, token):
    """The heights as lines of text; form: format of numbers; token: text at the holes."""
    rows = [[f"{z:{form}}".replace(".", decimal) for z in row] for row in Z]
    for i, j in holes:
        rows[i][j] = token
    return "\n".join(mark.join(row) for row in rows) + "\n"


LAYOUTS = [
    (mark, decimal)
    for mark, decimal in product([" ", "   ", "\t", ",", ";"], [".", ","])
    if mark != decimal
]
VARIANTS = [
    *((*layout, "none", "utf-8", "\n", ".4f", ()) for layout in LAYOUTS),
    *((*layout, "none", "utf-8", "\n", ".4f", EARLY) for layout in LAYOUTS),
    *((*layout, "none", "utf-8", "\n", ".4f", LATE) for layout in LAYOUTS),
    *((*LAYOUTS[k % 8], head, "utf-8", "\n", ".6e", LATE) for k, head in enumerate(HEADS)),
    *((*LAYOUTS[(3 * k) % 8], head, "latin-1", "\r\n", ".17g", ()) for k, head in enumerate(HEADS)),
    *(
        (*LAYOUTS[(5 * k) % 8], "comment", encoding, "\n", "g", EARLY)
        for k, encoding in enumerate(["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252"])
    ),
    *((*LAYOUTS[(5 * k) % 8], "none", "ascii", end, "10.3f", LATE) for k, end in enumerate("\r\n")),
]


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("token", ["nan", "***"])
def test_layouts_against_numpy(variant, token):
    mark, decimal, head, encoding, end, form, holes = variant
    numbers = body(mark, decimal, form, holes, token)
    title = (
        HEADS[head]
        if HEADS[head] is not None
        else (mark if mark.strip() else "\t").join("abcdef") + "\n"
    )
    text = (title + numbers).replace("\n", end)
    Path("z.txt").write_bytes(text.encode(encoding))
    topography = open_topography(File(kind="file", path="z.txt", **KEYS))
    wanted = numpy_reads(numbers, mark, decimal, [token])
    assert np.isnan(wanted).sum() == len(holes)
    assert np.array_equal(topography.rows(0, topography.n[0]), wanted, equal_nan=True)


@pytest.mark.parametrize("mark", [",", "\t", ";"])
def test_quoted_numbers_with_decimal_commas(mark):
    """The format of spreadsheets."""
    rows = [[f'"{z:.4f}"'.replace(".", ",") for z in row] for row in Z]
    Path("z.csv").write_text("\n".join(mark.join(row) for row in rows))
    topography = open_topography(File(kind="file", path="z.csv", **KEYS))
    assert np.array_equal(topography.rows(0, 240), Z)


def damaged(line, change):
    """The heights as text with one changed line."""
    lines = body("\t", ".", ".4f", (), "").splitlines()
    lines[line] = change(lines[line])
    return "\n".join(lines) + "\n"


DAMAGE = {
    "one number less": lambda line: line.rpartition("\t")[0],
    "one number more": lambda line: f"{line}\t1.0",
    "a blank in a number": lambda line: line.replace(".", ". ", 1),
    "two points": lambda line: line.replace(".", "..", 1),
    "a comma": lambda line: line.replace(".", ",", 1),
    "a letter": lambda line: line.replace(".", ".O", 1),
    "a hash": lambda line: line.replace("\t", "\t#", 1),
    "a hash in a number": lambda line: line.replace(".", "#", 1),
    "a unit": lambda line: f"{line} nm",
    "nothing": lambda line: "",
    "hexadecimal": lambda line: "0x10" + line[line.index("\t") :],
    "a null": lambda line: line.replace("\t", "\0", 1),
}


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("line", [2, 150, 238])
def test_damage_is_refused(damage, line):
    """In early, middle and late lines."""
    Path("z.txt").write_text(damaged(line, DAMAGE[damage]))
    with refused("surface.path"):
        topography = open_topography(File(kind="file", path="z.txt", **KEYS))
        topography.rows(0, topography.n[0])
