"""The result table for notebooks."""

from html import escape

from .table import cells, remarks, surface_line


def html_table(steps: list[dict], surface: dict, indices=None, notes=(), across: bool = True) -> str:
    """HTML of what `table.table` says; across: a row for each step, otherwise a column."""
    indices = list(range(len(steps))) if indices is None else indices
    rows = cells(steps, indices, surface)
    if not across:
        rows = [list(row) for row in zip(*rows)][1:]
    lines = ["<tr>" + "".join(f'<td style="text-align:right">{escape(cell)}</td>' for cell in row) + "</tr>" for row in rows]
    below = [surface_line(surface), *remarks(indices, steps), *(f"note: {note}" for note in notes)]
    return "\n".join(["<table>", *lines, "</table>", "<small>" + "<br>".join(escape(line) for line in below) + "</small>"])
