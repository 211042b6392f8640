"""Text files of heights in many layouts: read as by NumPy, to the bit, or refused where NumPy would
read something else than was written."""

import re
import warnings
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from contacts import opened, random_heights
from hypothesis import example, given, settings
from hypothesis import strategies as st
from refusal import refused

import hpc_gfmd
from hpc_gfmd.surface.doubtful_numbers import stand_in_notes
from hpc_gfmd.util.errors import SurfaceWarning

Z = np.round(20 * random_heights((240, 6)), 4)  # more lines than those that decide the layout
KEYS = {"physical_sizes": (24.0, 0.6)}
LAYOUTS = [(mark, decimal) for mark in [" ", "   ", "\t", ",", ";"] for decimal in ".,"]
LAYOUTS.remove((",", ","))
HEADS = {
    "none": "",
    "comment": "# heights\n# of a scan\n",
    "words": "Profiler 3, version 2\nranges: a b\n\n",
    "names": "abcdef",
    "percent": "% heights in nm\n",
}
ENCODINGS = ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1", "cp1252"]


def body(mark, decimal, form, holes, token):
    """The heights as lines of text; form: format of numbers; token: text at the holes."""
    rows = [[f"{z:{form}}".replace(".", decimal) for z in row] for row in Z]
    for i, j in holes:
        rows[i][j] = token
    return "\n".join(mark.join(row) for row in rows) + "\n"


@settings(max_examples=60)
@given(
    st.sampled_from(LAYOUTS),
    st.sampled_from(list(HEADS)),
    st.sampled_from(ENCODINGS),
    st.sampled_from(["\n", "\r\n", "\r"]),
    st.sampled_from([".4f", ".6e", ".17g", "g", "10.3f"]),
    st.sampled_from([(), [(0, 0), (3, 5)], [(230, 2), (239, 5)]]),
    st.sampled_from(["nan", "***"]),
)
@example(("\t", ","), "names", "utf-16-be", "\r\n", ".17g", [(0, 0), (3, 5)], "***")
def test_layouts_against_numpy(layout, head, encoding, end, form, holes, token):
    """Marks, decimal commas, heads, encodings, ends of lines, formats of numbers and holes."""
    mark, decimal = layout
    numbers = body(mark, decimal, form, holes, token)
    title = HEADS[head]
    if head == "names":
        title = (mark if mark.strip() else "\t").join(title) + "\n"
    Path("z.txt").write_bytes((title + numbers).replace("\n", end).encode(encoding))
    topography = opened("z.txt", **KEYS)
    plain = numbers.replace(decimal, ".").replace(token, "nan")
    wanted = np.genfromtxt(StringIO(plain), delimiter=None if set(mark) == {" "} else mark)
    assert np.isnan(wanted).sum() == len(holes)
    assert np.array_equal(topography.rows(0, topography.n[0]), wanted, equal_nan=True)


@pytest.mark.parametrize("mark", [",", "\t", ";"])
def test_quoted_numbers_with_decimal_commas(mark):
    """The format of spreadsheets."""
    rows = [[f'"{z:.4f}"'.replace(".", ",") for z in row] for row in Z]
    Path("z.csv").write_text("\n".join(mark.join(row) for row in rows))
    assert np.array_equal(opened("z.csv", **KEYS).rows(0, 240), Z)


@pytest.mark.parametrize("end", ["", ", "])
@pytest.mark.parametrize("keys", [{}, {"decimal": ","}])
def test_decimal_commas_between_commas_and_spaces(keys, end):
    """A comma before white space separates; whole numbers, holes and names are read, too."""
    rows = [[f"{z:.15g}".replace(".", ",") for z in row] for row in Z]
    rows[3][2] = "5"
    rows[4][2] = "nan"
    numbers = "".join(", ".join(row) + end + "\n" for row in rows)
    Path("z.txt").write_text("heights, in um\n" + numbers)
    wanted = Z.copy()
    wanted[3:5, 2] = 5, np.nan
    assert np.array_equal(opened("z.txt", **KEYS, **keys).rows(0, 240), wanted, equal_nan=True)


@pytest.mark.parametrize(
    ("line", "decimal", "numbers"),
    [
        ("1, 2, 3", None, [1, 2, 3]),
        ("1,2,3", None, [1, 2, 3]),
        ("1.5, 2.5,3.5", None, [1.5, 2.5, 3.5]),
        ("1,2, 3,-4", None, [1, 2, 3, -4]),  # a sign begins a number
        ("1000,2000,1000, 100", None, [1000, 2000, 1000, 100]),
        ("1,2, 3,4, 5,6", ".", [1, 2, 3, 4, 5, 6]),
        ("1,2, 3,4, 5,6", ",", [1.2, 3.4, 5.6]),
        ("1, 2, 3", ",", [1, 2, 3]),
        ("-0,2, 3,4, 5,6", None, [-0.2, 3.4, 5.6]),
        ("1,2, 3,04, 5,6", None, [1.2, 3.04, 5.6]),
    ],
)
def test_commas_with_and_without_spaces(line, decimal, numbers):
    Path("z.txt").write_text(f"{line}\n" * 4)
    keys = {"coordinates": "none"} | ({"decimal": decimal} if decimal else {})
    assert np.array_equal(opened("z.txt", **KEYS, **keys).rows(0, 4), [numbers] * 4)


def test_columns_of_one_width_are_whole_numbers():
    """With decimal commas, the lines would have different numbers of columns."""
    z = np.random.default_rng(0).integers(90, 110, (8, 5))
    Path("z.txt").write_text("\n".join(",".join(f"{z:3d}" for z in row) for row in z))
    assert np.array_equal(opened("z.txt", **KEYS).rows(0, 8), z)


@pytest.mark.parametrize("line", ["1,2, 3,4", "1,2, 3, 5,6", "12,34, 56,78, 9,1e-3"])
def test_commas_of_two_meanings_are_refused(line):
    """Pairs of whole numbers, or numbers with decimal commas."""
    Path("z.txt").write_text(f"{line}\n" * 4)
    with refused("line 1: .*be decimal ones, allowed: surface.decimal"):
        opened("z.txt", **KEYS)


def test_comments_decide_nothing_about_commas():
    """A date in one is no number with a decimal comma."""
    Path("z.txt").write_text("1,2, 3,4, 5,6\n" * 4 + "# made 12,05,2024\n")
    with refused("line 1: .*be decimal ones, allowed: surface.decimal"):
        opened("z.txt", **KEYS)


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


@pytest.mark.parametrize("line", [2, 150, 238])
def test_damage_is_refused(line):
    """In early, middle and late lines."""
    for change in DAMAGE.values():
        lines = body("\t", ".", ".4f", (), "").splitlines()
        lines[line] = change(lines[line])
        Path("z.txt").write_text("\n".join(lines) + "\n")
        with refused("surface.path"):
            opened("z.txt", **KEYS).rows(0, 239)


@pytest.mark.parametrize(
    ("number", "text"),
    [(-9999, "-9999"), (1e38, "1e+38"), (float(np.finfo("f4").max), "3.4028234663852886e+38")],
)
def test_a_number_that_may_stand_for_missing_points(tmp_path, number, text):
    """One that several points have, further from all others than these from each other."""
    z = np.random.default_rng(0).normal(size=(8, 8)).round(3)
    z[2:4, 5] = number
    np.savetxt(tmp_path / "z.txt", z)
    keys = {"physical_sizes": (1.0, 1.0), "boundary": "mirror"}
    with pytest.warns(SurfaceWarning, match=f"2 points are {re.escape(text)}, all others"):
        hpc_gfmd.read_surface(tmp_path / "z.txt", **keys)
    filled = hpc_gfmd.read_surface(tmp_path / "z.txt", missing=[text], fill="harmonic", **keys)
    assert np.abs(filled.heights).max() < 10
    assert not any("stand for" in note for note in filled.notes)


def test_a_single_number_that_may_stand_for_a_missing_point():
    """One that is more than a hundred ranges of all others away, on either side."""
    z = np.linspace(0.5, 2.5, 64).reshape(8, 8)
    for number in (-9999.0, -200.0, 9999.0):
        z[3, 5] = number
        (note,) = stand_in_notes(z)
        assert f"1 point is {number:g}, all others 0.5 to 2.5" in str(note)
        assert stand_in_notes(z, missing=[number]) == []


@pytest.mark.parametrize("deep", [[-90.0], [-9999.5], [-4.0, -4.5], [-50.25, -50.25]])
def test_deep_points_are_no_stand_ins(tmp_path, deep):
    """A single one that is not far away or no whole number, several of different depths, and a
    bottom that is no whole number.
    """
    z = np.random.default_rng(0).normal(size=(8, 8)).round(3)
    z[0, : len(deep)] = deep
    np.savetxt(tmp_path / "z.txt", z)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        keys = {"physical_sizes": (1.0, 1.0), "boundary": "mirror"}
        surface = hpc_gfmd.read_surface(tmp_path / "z.txt", **keys)
    assert not any("stand for" in note for note in surface.notes)


def test_stand_ins_of_other_types():
    """Masked points have no height; numbers of 16 bits are not subtracted in 16 bits."""
    z = np.random.default_rng(0).integers(-20000, 30000, (8, 8)).astype(np.int16)
    z[2:4, 5] = -32768
    assert stand_in_notes(z) == []
    z //= 4
    z[2:4, 5] = -32768
    assert "2 points are -32768" in str(stand_in_notes(z)[0])
    assert stand_in_notes(np.ma.masked_equal(z, -32768)) == []
    for empty in (np.nan, np.inf, 0.0):
        assert stand_in_notes(np.full((4, 4), empty)) == []


def test_missing_heights_of_an_array():
    z = np.random.default_rng(0).normal(size=(8, 8))
    z[2:4, 5] = -9999
    keys = {"physical_sizes": (1.0, 1.0), "boundary": "mirror", "fill": "harmonic"}
    with pytest.warns(SurfaceWarning, match="2 points are -9999"):
        assert hpc_gfmd.prepare_surface(z, **keys).heights.min() == -9999
    assert hpc_gfmd.prepare_surface(z, missing=["-9999"], **keys).heights.min() > -9
