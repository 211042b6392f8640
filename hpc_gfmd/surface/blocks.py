"""The numbers of a text, all of them: every line after the header obeys the layout, or the text is
refused."""

from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from .layout import NoNumber, TextLayout, is_comment


@dataclass
class Block:
    """Lines of numbers without another line between them.

    Attributes
    ----------
    first_line : int
        Its number, from 1.
    header : list of str
        Lines before them.
    numbers : array of float
        Line by line.
    lines : int
    """

    first_line: int
    header: list[str]
    numbers: array = field(default_factory=lambda: array("d"))
    lines: int = 0

    def table(self) -> np.ndarray:
        """Return the numbers, float64, shape (lines, columns)."""
        return np.frombuffer(self.numbers, np.float64).reshape(self.lines, -1)


def read_blocks(lines: Iterable[str], layout: TextLayout) -> list[Block]:
    """Read the numbers of a text.

    Parameters
    ----------
    lines : iterable of str
        All lines of the text.
    layout : TextLayout
        Of its first lines.

    Returns
    -------
    list of Block
        Those that blank lines or comments separate; one where they separate every line.

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
    """Put blocks together, as if nothing separated them."""
    whole = Block(blocks[0].first_line, blocks[0].header)
    for block in blocks:
        whole.numbers.extend(block.numbers)
        whole.lines += block.lines
    return whole


def _row(line: str, number: int, layout: TextLayout) -> list[float]:
    """Read the numbers of a line. Raises ValueError."""
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
