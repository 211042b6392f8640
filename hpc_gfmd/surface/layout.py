"""The layout of a text of numbers: separator, decimal mark, length of the header.

It is found in the first lines; blocks.py holds the whole text to it.
"""

import csv
import re
from dataclasses import dataclass
from typing import Any

LOOKED_AT = 200  # lines
MARKS = ("\t", ";", ",", None)  # between numbers; None: white space
WORDS = (  # in any case
    *("na", "n/a", "#n/a", "n.a.", "nan", "null", "none", "nodata", "no_data", "no-data", "bad"),
    *("invalid", "masked", "undefined", "missing", "1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind"),
)
MISSING = frozenset(["", *WORDS, *(sign * k for sign in "*-" for k in range(1, 12))])
TWO_WORDS = re.compile(r"\bno data\b", re.I)  # Zygo's, in which white space marks nothing
_COMMENT = re.compile(r"(?:^|\s)#.*")  # not within a token


class NoNumber(ValueError):
    """A token is not a number; str() of the error is the token."""


@dataclass(frozen=True)
class TextLayout:
    """How the numbers of a text are written.

    Attributes
    ----------
    mark : str or None
        What separates numbers; None: white space.
    decimal : str
        "." or ",".
    columns : int
        Numbers in a line.
    header_lines : int
        Lines before the numbers.
    missing : frozenset of str
        Texts that stand for missing points, in lower case.
    ended : bool
        Whether every line ends with a mark, after which there is no number.
    """

    mark: str | None
    decimal: str
    columns: int
    header_lines: int
    missing: frozenset[str]
    ended: bool = False

    def tokens(self, line: str) -> list[str]:
        """Split a line into the texts of its numbers, without a comment or a mark at its end."""
        tokens = tokens_of(line, self.mark, self.missing)
        if self.ended and len(tokens) == self.columns + 1 and not tokens[-1]:
            del tokens[-1]
        return tokens

    def number(self, token: str) -> float:
        """Convert a token to a number, nan for a missing one. Raises NoNumber for other texts."""
        return number_of(token, self.decimal, self.missing)


def layout_of(lines: list[str], spec: Any) -> TextLayout:
    """Find the layout in which most numbers of the first lines can be read.

    Parameters
    ----------
    lines : list of str
        First lines of a text.
    spec : scene.File
        Its decimal and skip_lines override what the lines show, its missing adds texts for missing
        points.

    Returns
    -------
    TextLayout

    Raises
    ------
    ValueError
        If there are no numbers, or if the header seems to end with a line of numbers (unless
        spec.skip_lines gives its length).
    """
    missing = MISSING | {text.lower() for text in spec.missing}
    decimals = (spec.decimal,) if spec.decimal else (".", ",")
    candidates = [
        _candidate(lines, mark, decimal, missing, spec.skip_lines)
        for decimal in decimals
        for mark in MARKS
        if mark != decimal or any('"' in line for line in lines)  # quoted numbers hold marks
    ]
    _, layout = max(candidates, key=lambda candidate: candidate[0])
    if not layout.columns:
        rest = lines[spec.skip_lines or 0 :]
        begin = next((line.split()[0] for line in rest if line.strip()), "")
        where = f"after line {spec.skip_lines}" if spec.skip_lines else "at its beginning"
        raise ValueError(
            f"there are no lines of numbers {where}, in {len(rest)} lines; it begins with"
            f" {begin[:40]!r}"
        )
    if spec.skip_lines is None:
        _require_header(lines, layout)
    return layout


def tokens_of(line: str, mark: str | None, missing: frozenset[str] = MISSING) -> list[str]:
    """Split a line into tokens without white space around them, leaving out a comment at its end.

    Parameters
    ----------
    line : str
    mark : str or None
        What separates tokens; None: white space.
    missing : frozenset of str
        Texts that stand for missing points. Those that contain white space become "nodata" if mark
        is None.

    Returns
    -------
    list of str
    """
    if "#" in line:
        line = _COMMENT.sub("", line)
    if '"' in line and mark:
        return [token.strip() for token in next(csv.reader([line], delimiter=mark), [])]
    if mark is None:
        if "no data" in line.lower():
            line = TWO_WORDS.sub("nodata", line)
        for text in missing:
            if " " in text:
                line = re.sub(rf"(?<!\S){re.escape(text)}(?!\S)", "nodata", line, flags=re.I)
        return line.split()
    return [token.strip() for token in line.strip("\r\n").split(mark)] if line.strip() else []


def number_of(token: str, decimal: str, missing: frozenset[str]) -> float:
    """Convert a token to a number.

    Parameters
    ----------
    token : str
    decimal : str
        "." or ",".
    missing : frozenset of str
        Texts that stand for missing points, in lower case.

    Returns
    -------
    float
        nan if the token stands for a missing point.

    Raises
    ------
    NoNumber
        For any other text, and for a token with a point if the decimal mark is a comma.
    """
    if token.lower() in missing or token.lower() == "no data":
        return float("nan")
    if "_" in token or (decimal == "," and "." in token):
        raise NoNumber(token)
    try:
        return float(token.replace(decimal, "."))
    except ValueError:
        raise NoNumber(token) from None


def count_numbers(tokens: list[str], decimal: str, missing: frozenset[str]) -> int:
    """Return how many tokens are numbers, "nan" among them; the others stand for missing points.

    Raises NoNumber for the first token that is neither.
    """
    values = [number_of(token, decimal, missing) for token in tokens]
    return sum(value == value or token.lower() == "nan" for value, token in zip(values, tokens))


def is_comment(line: str) -> bool:
    """Whether a line is a comment as a whole."""
    return line.lstrip().startswith("#")


def is_whole(token: str) -> bool:
    """Whether a token is a whole number without a decimal mark."""
    return token.lstrip("+-").isdigit()


def _candidate(
    lines: list[str], mark: str | None, decimal: str, missing: frozenset[str], skip: int | None
) -> tuple[tuple, TextLayout]:
    """Return (score, layout) for a mark and a decimal mark; the layout with the highest score wins.

    The layout has the number of columns whose lines hold the most numbers in total; that total,
    and then whether there is a mark other than white space, is the score. missing: texts that stand
    for missing points, in lower case. skip: number of lines that belong to the header anyway, None
    for 0. If no line can be read the layout has 0 columns.
    """
    numbers_of: dict[int, int] = {}  # {columns: numbers in lines of so many}
    first_of: dict[int, int] = {}
    open_ends: set[int] = set()  # columns of lines that do not end with a mark
    for k, line in enumerate(lines[skip or 0 :], skip or 0):
        tokens = [] if is_comment(line) else tokens_of(line, mark, missing)
        columns = len(tokens)
        try:
            numbers = count_numbers(tokens, decimal, missing)
        except NoNumber:
            continue
        if not numbers and columns < 3:
            continue
        numbers_of[columns] = numbers_of.get(columns, 0) + numbers
        first_of.setdefault(columns, k)
        if tokens[-1]:
            open_ends.add(columns)
    if not any(numbers_of.values()):
        return (0, False), TextLayout(mark, decimal, 0, len(lines), missing)
    columns = max(numbers_of, key=lambda count: numbers_of[count])
    ended = columns > 1 and columns not in open_ends
    layout = TextLayout(mark, decimal, columns - ended, first_of[columns], missing, ended)
    return (numbers_of[columns], mark is not None), layout


def _require_header(lines: list[str], layout: TextLayout) -> None:
    """Raise ValueError if lines just before the numbers hold numbers too.

    lines: the first lines of the text, in which `layout` was found. Such lines may belong to the
    map, with an unknown token or damaged. The search goes backwards from the numbers to a blank
    line or a comment.
    """
    hint = "surface.skip_lines tells how long the header is"
    for k in range(layout.header_lines - 1, -1, -1):
        if not lines[k].strip() or is_comment(lines[k]):
            return
        tokens = layout.tokens(lines[k])
        unknown = [token for token in tokens if not _is_number(token, layout)]
        known = [token for token in tokens if token not in unknown]
        numbers = count_numbers(known, layout.decimal, layout.missing)
        if len(tokens) == layout.columns and numbers and unknown != tokens[:1]:
            raise ValueError(
                f"line {k + 1}: found {unknown[0]!r}, allowed: numbers, as in the lines after it;"
                f" surface.missing names what stands for missing points, {hint}"
            )
        if not unknown and len(tokens) > 2:
            raise ValueError(
                f"line {k + 1}: found {len(tokens)} numbers, allowed: {layout.columns}, as in line"
                f" {layout.header_lines + 1}; {hint}"
            )


def _is_number(token: str, layout: TextLayout) -> bool:
    """Whether a token is a number or stands for a missing point."""
    try:
        layout.number(token)
    except NoNumber:
        return False
    return True
