"""How the numbers of a text are written: separator, decimal mark, length of the header."""

import csv
import re
from dataclasses import dataclass, replace
from typing import Any

LOOKED_AT = 200  # lines
MARKS = ("\t", ";", ",", None)  # between numbers; None: white space
WORDS = (  # in any case
    *("na", "n/a", "#n/a", "n.a.", "nan", "null", "none", "nodata", "no_data", "no-data", "bad"),
    *("invalid", "masked", "undefined", "missing", "1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind"),
    "no data",  # Zygo's, in which white space marks nothing
)
MISSING = frozenset(["", *WORDS, *(sign * k for sign in "*-" for k in range(1, 12))])
_COMMENT = re.compile(r"(?:^|\s)#.*")  # not within a token
_COMMA_AND_SPACE = re.compile(r",(?:\s+|$)")  # between numbers with decimal commas
_ONLY_DECIMALS = re.compile(r"-0,\d|\d,0\d")  # a comma in these is not between whole numbers


@dataclass(frozen=True)
class TextLayout:
    """How the numbers of a text are written."""

    mark: str | None  # between numbers; None: white space; "," and white space if decimal is ","
    decimal: str  # "." or ","
    missing: frozenset[str]  # texts that stand for missing points, in lower case
    columns: int = 0  # numbers in a line; 0 if no line can be read
    header_lines: int = 0  # lines before the numbers
    ended: bool = False  # whether every line ends with a mark, after which there is no number
    lines: int = 0  # of so many columns, among those that were looked at
    numbers: int = 0  # in these lines

    def tokens(self, line: str) -> list[str]:
        """Split a line into the texts of its numbers, without a comment or a mark at its end."""
        line = _COMMENT.sub("", line) if "#" in line else line
        if self.mark is None:
            for text in self.missing:
                if " " in text and text.split()[0] in line.lower():
                    line = re.sub(rf"(?<!\S){re.escape(text)}(?!\S)", "nodata", line, flags=re.I)
            return line.split()
        if '"' in line:
            tokens = next(csv.reader([line], delimiter=self.mark), [])
        elif not line.strip():
            tokens = []
        elif self.mark == self.decimal:
            tokens = _COMMA_AND_SPACE.split(line.strip("\r\n"))
        else:
            tokens = line.strip("\r\n").split(self.mark)
        tokens = [token.strip() for token in tokens]
        is_ended = self.ended and len(tokens) == self.columns + 1 and not tokens[-1]
        return tokens[:-1] if is_ended else tokens

    def number(self, token: str) -> float | None:
        """Return a token's number, nan if missing, None for text; numbers that mark missing points
        stay, as they may be coordinates.
        """
        is_plain = "_" not in token and not (self.decimal == "," and "." in token)
        try:
            return float(token.replace(self.decimal, ".") if is_plain else "")
        except ValueError:
            return float("nan") if token.lower() in self.missing else None

    def count(self, tokens: list[str]) -> int | None:
        """Return how many tokens are numbers, "nan" among them; None if one is another text."""
        values = [self.number(token) for token in tokens]
        if None in values:
            return None
        return sum(value == value or token.lower() == "nan" for value, token in zip(values, tokens))


def layout_of(lines: list[str], spec: Any) -> TextLayout:
    """Return the layout that reads most numbers of the first lines; spec.decimal, skip_lines and
    missing override. ValueError without numbers, if the header seems to end with some, or if commas
    may be decimal ones.
    """
    missing = MISSING | {text.lower() for text in spec.missing}
    skip = spec.skip_lines or 0
    candidates = [
        _measured(TextLayout(mark, decimal, missing), lines, skip)
        for decimal in ((spec.decimal,) if spec.decimal else (".", ","))
        for mark in MARKS
    ]
    layout = max(candidates, key=lambda layout: (layout.numbers, layout.mark is not None))
    if not layout.columns:
        rest = lines[skip:]
        begin = next((line.split()[0] for line in rest if line.strip()), "")
        where = f"after line {skip}" if skip else "at its beginning"
        raise ValueError(
            f"there are no lines of numbers {where}, in {len(rest)} lines; it begins with"
            f" {begin[:40]!r}"
        )
    if layout.mark == "," and spec.decimal is None:
        with_commas = next(c for c in candidates if c.mark == c.decimal)
        layout = _one_meaning_of_commas(layout, with_commas, lines)
    if spec.skip_lines is None:
        _require_header(lines, layout)
    return layout


def is_comment(line: str) -> bool:
    """Whether a line is a comment as a whole."""
    return line.lstrip().startswith("#")


def _measured(layout: TextLayout, lines: list[str], skip: int) -> TextLayout:
    """Return a layout with the number of columns whose lines hold the most numbers in total."""
    numbers_of: dict[int, int] = {}  # {columns: numbers in lines of so many}
    lines_of: dict[int, int] = {}
    first_of: dict[int, int] = {}
    open_ends: set[int] = set()  # columns of lines that do not end with a mark
    for k, line in enumerate(lines[skip:], skip):
        tokens = [] if is_comment(line) else layout.tokens(line)
        columns = len(tokens)
        numbers = layout.count(tokens)
        if numbers is None or (numbers == 0 and columns < 3):
            continue
        numbers_of[columns] = numbers_of.get(columns, 0) + numbers
        lines_of[columns] = lines_of.get(columns, 0) + 1
        first_of.setdefault(columns, k)
        if tokens[-1]:
            open_ends.add(columns)
    if not any(numbers_of.values()):
        return layout
    columns = max(numbers_of, key=lambda count: numbers_of[count])
    ended = columns > 1 and columns not in open_ends
    return replace(
        layout,
        columns=columns - ended,
        header_lines=first_of[columns],
        ended=ended,
        lines=lines_of[columns],
        numbers=numbers_of[columns],
    )


def _one_meaning_of_commas(
    layout: TextLayout, with_commas: TextLayout, lines: list[str]
) -> TextLayout:
    """Return which of two layouts explains that a text has commas with and without white space
    after them. ValueError if these may be decimal commas or may separate whole numbers.
    """
    is_explained = with_commas.columns > 1 and with_commas.lines >= layout.lines
    if not is_explained or with_commas.numbers >= layout.numbers:
        return layout
    numbers = [_COMMENT.sub("", line) for line in lines[with_commas.header_lines :]]
    if with_commas.lines == layout.lines and not any(map(_ONLY_DECIMALS.search, numbers)):
        where = f"line {with_commas.header_lines + 1}"
        raise ValueError(
            f"{where}: found {numbers[0].strip()[:40]!r}, in which commas may be decimal ones,"
            ' allowed: surface.decimal = ",", or "." if all commas separate numbers'
        )
    return with_commas


def _require_header(lines: list[str], layout: TextLayout) -> None:
    """Raise ValueError if lines just before the numbers, back to a blank line or comment, hold
    numbers: they may belong to the map.
    """
    hint = "surface.skip_lines tells how long the header is"
    for k in range(layout.header_lines - 1, -1, -1):
        if not lines[k].strip() or is_comment(lines[k]):
            return
        tokens = layout.tokens(lines[k])
        unknown = [token for token in tokens if layout.number(token) is None]
        numbers = layout.count([token for token in tokens if token not in unknown])
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
