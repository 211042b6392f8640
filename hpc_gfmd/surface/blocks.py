"""All numbers of a text. A text is refused if any line after the header breaks its layout."""

from array import array
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np

from .layout import NoNumber, TextLayout, is_comment


@dataclass
class Block:
    """Successive lines of numbers.

    Attributes
    ----------
    first_line : int
        Number of the first of them in the text, from 1.
    header : list of str
        Lines before them: header and comments since the block before.
    numbers : array.array or ndarray of float
        Line by line.
    lines : int
        Number of lines of numbers.
    """

    first_line: int
    header: list[str]
    numbers: Any = field(default_factory=lambda: array("d"))
    lines: int = 0

    def table(self) -> np.ndarray:
        """Return a view of the numbers, float64, shape (lines, columns).

        While it exists `numbers` cannot be extended.
        """
        return np.frombuffer(self.numbers, np.float64).reshape(self.lines, -1)


def plain_block(lines: Iterator[str], layout: TextLayout) -> Block | None:
    """Read a text whose lines after the header are numbers alone, by NumPy's parser.

    Parameters
    ----------
    lines : iterator of str
        All lines of the text.
    layout : TextLayout

    Returns
    -------
    Block or None
        None if NumPy refuses a line, or if a line is blank: then `read_blocks` says what is wrong,
        or finds gaps and blocks.
    """
    if layout.decimal == layout.mark:
        return None
    header = list(islice(lines, layout.header_lines))
    count = 0  # lines up to the last that is not blank

    def with_points() -> Iterator[str]:
        """Yield the lines with decimal points and without a mark at their end."""
        nonlocal count
        for number, line in enumerate(lines, 1):
            text = line.rstrip("\r\n ")
            if text:
                count = number
            if layout.decimal == ",":
                if "." in text:
                    raise ValueError
                text = text.replace(",", ".")
            yield text.removesuffix(layout.mark) if layout.ended and layout.mark else text

    try:
        table = np.loadtxt(with_points(), delimiter=layout.mark, comments=None, ndmin=2)
    except UnicodeDecodeError:
        raise
    except ValueError:
        return None
    if table.shape != (count, layout.columns):  # NumPy skips blank lines without a word
        return None
    return Block(layout.header_lines + 1, header, table.ravel(), count)


def read_blocks(lines: Iterable[str], layout: TextLayout) -> list[Block]:
    """Read all numbers of a text, in blocks that blank lines or comments separate.

    Parameters
    ----------
    lines : iterable of str
        All lines of the text.
    layout : TextLayout
        Layout of its first lines, which all others must have.

    Returns
    -------
    list of Block
        A single block if every line is a block of its own (blank lines between all lines).

    Raises
    ------
    ValueError
        Names the first line that does not obey the layout, and what is wrong with it.
    """
    blocks: list[Block] = []
    header: list[str] = []
    separated = True
    for number, line in enumerate(lines, 1):
        if number <= layout.header_lines or is_comment(line):
            header.append(line)
            separated = True
            continue
        if not line.strip("\r\n "):
            separated = True
            continue
        row = _row(line, number, layout)
        if separated:
            blocks.append(Block(number, header))
            header = []
            separated = False
        blocks[-1].numbers.extend(row)
        blocks[-1].lines += 1
    if len(blocks) > 1 and all(block.lines == 1 for block in blocks):  # doubled line ends
        return [joined(blocks)]
    return blocks


def joined(blocks: list[Block]) -> Block:
    """Return one new Block with the numbers of several, and with the header of the first."""
    whole = Block(blocks[0].first_line, blocks[0].header)
    for block in blocks:
        whole.numbers.extend(block.numbers)
        whole.lines += block.lines
    return whole


def _row(line: str, number: int, layout: TextLayout) -> list[float]:
    """Read the numbers of the line with this number (from 1 on), nan for missing ones.

    Raises ValueError, with the number of the line, if the line does not obey the layout.
    """
    complete = "" if line.endswith(("\n", "\r")) else " (it is the last one: is the file complete?)"
    tokens = layout.tokens(line)
    if len(tokens) != layout.columns:
        raise ValueError(
            f"line {number}: found {len(tokens)} columns, allowed: {layout.columns}, as in line"
            f" {layout.header_lines + 1}{complete}"
        )
    if layout.decimal == "." and "_" not in line:
        try:
            return list(map(float, tokens))
        except ValueError:
            pass
    try:
        return list(map(layout.number, tokens))
    except NoNumber as unknown:
        raise ValueError(
            f"line {number}: found {str(unknown)!r}, allowed: numbers; surface.missing names what"
            f" stands for missing points{complete}"
        ) from None
