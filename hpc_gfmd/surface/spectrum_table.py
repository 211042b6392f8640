"""Tables of power spectra in text files: columns q and C, with units in the head."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from ..util.errors import SceneError, one_line
from ..util.lengths import length_factor
from .spectra import NO_UNIT, require_rows

LARGEST = 64 * 2**20  # bytes of a table that is read
NAME = "([A-Za-zµμÅ]+)"
PER_LENGTH = re.compile(rf"1\s*/\s*{NAME}|{NAME}\s*(?:\^|\*\*)?\s*(?:-1|⁻¹)")
POWER = re.compile(rf"{NAME}\s*(?:\^|\*\*)?\s*([34³⁴])")
DIMENSIONS = {"3": 1, "³": 1, "4": 2, "⁴": 2}
KINDS = {1: "profiles (length^3)", 2: "areas (length^4)"}
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?|[-+]?(nan|inf)", re.IGNORECASE)


def read_spectrum_table(
    path: Any, unit: str | None, dimension: int | None
) -> tuple[np.ndarray, np.ndarray, int, str]:
    """Return q (1/unit), C (unit^4, of profiles unit^3), dimension and unit of the first two
    columns of a table; q = 0 is ignored. unit, dimension: if the head has none.
    """
    head, rows = _head_and_rows(path)
    q, C = rows[rows[:, 0] != 0].T
    require_rows(q, C, "surface.path", f" of {path}")
    q_unit, C_unit, head_dimension = _units(head)
    if head_dimension and dimension and dimension != head_dimension:
        raise SceneError(
            f"surface.dimension: found {dimension}, but C in {C_unit}^{2 + head_dimension} in"
            f" {path}, allowed: {head_dimension}, or none"
        )
    dimension = head_dimension or dimension
    if dimension is None:
        raise SceneError(
            f"surface.dimension: not given, and the head of {path} has no unit of C, allowed: 2 for"
            f" C of {KINDS[2]}, 1 for C of {KINDS[1]}"
        )
    in_head = q_unit or C_unit
    if in_head and unit and length_factor(in_head) != length_factor(unit):
        raise SceneError(
            f'surface.unit: found "{unit}", but {in_head} in {path}, allowed: "{in_head}", or none'
        )
    unit = in_head or unit or ""
    if q_unit and C_unit:  # they may differ
        ratio = (length_factor(C_unit) or 1.0) / (length_factor(q_unit) or 1.0)
        C = C * ratio ** (2 + dimension)
    return q, C, dimension, unit


def is_spectrum_table(path: Any) -> bool:
    """Whether a file is a table of a spectrum: its head names q, or has the units of q and C."""
    try:
        head, _ = _head_and_rows(path)
    except SceneError:
        return False
    q_unit, _, dimension = _units(head)
    names_q = re.match(r"[#\s]*q\b", head, re.IGNORECASE)
    return bool(q_unit and dimension) or names_q is not None


def _head_and_rows(path: Any) -> tuple[str, np.ndarray]:
    """Return the last line before the numbers, and the numbers of the first two columns."""
    try:
        size = Path(path).stat().st_size
        if size > LARGEST:
            raise SceneError(
                f"surface.path: found {size / 2**20:.0f} MiB in {path}, allowed: a table of a"
                f" spectrum, up to {LARGEST / 2**20:.0f} MiB"
            )
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise SceneError(
            f"surface.path: cannot read {path}: {one_line(str(error.strerror))}, allowed: a text"
            " with the columns q and C"
        ) from None
    except UnicodeDecodeError:
        raise SceneError(
            f"surface.path: found {path}, which is no text, allowed: a table"
        ) from None
    head = ""
    rows: list[list[str]] = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        cells = _cells(line)
        if len(cells) >= 2 and all(NUMBER.fullmatch(cell) for cell in cells[:2]):
            rows.append(cells[:2])
        elif rows:
            raise SceneError(
                f"surface.path: found {one_line(line, 60)!r} in line {number} of {path}, allowed:"
                " two numbers, q and C"
            )
        else:
            head = line
    if not rows:
        raise SceneError(f"surface.path: found no numbers in {path}, allowed: columns q and C")
    return head, np.array(rows, dtype=float)


def _cells(line: str) -> list[str]:
    """Return the cells of a line; commas inside cells of another separator are decimal ones."""
    parts = re.split(r"[;\t]", line) if re.search(r"[;\t]", line.strip()) else line.split()
    parts = [part.strip(" ,") for part in parts]
    parts = [part for part in parts if part]
    if len(parts) == 1:
        return re.split(r"\s*,\s*", parts[0])
    return [part.replace(",", ".") for part in parts]


def _units(head: str) -> tuple[str, str, int | None]:
    """Return the units of length of q and of C, "" where there is none, and the dimension of C."""
    q_unit = C_unit = ""
    dimension = None
    for match in PER_LENGTH.finditer(head):
        name = match[1] or match[2]
        if not q_unit and length_factor(name):
            q_unit = name
    for match in POWER.finditer(head):
        is_unit = bool(length_factor(match[1]))
        if dimension is None and (is_unit or match[1] == NO_UNIT):
            C_unit = match[1] if is_unit else ""
            dimension = DIMENSIONS[match[2]]
    return q_unit, C_unit, dimension
