"""Rows as text: templates that rows fill in, numbers with their errors, Markdown."""

from string import Formatter
from typing import Any

from .rows import Rows


def quoted(value: Any, sigma: float | None = None) -> str:
    """A number with its uncertainty in two digits, "2.060 ± 0.012"; "-" for None."""
    if value is None:
        return "-"
    if sigma is None or not sigma > 0:
        return f"{value:.3g}"
    places = max(0, 1 - int(f"{sigma:e}".rpartition("e")[2]))
    return (
        f"{value:.{places}f} ± {sigma:.{places}f}" if places < 8 else f"{value:.3g} ± {sigma:.2g}"
    )


class _Filled(Formatter):
    """str.format of a row's columns. `{kappa:±}`: with its standard error, column kappa_se;
    `{eps_f:1/}`: its inverse, "1/16"; "-" for None, nothing for a column that is not there."""

    def get_field(self, name: str, args: Any, row: Any) -> Any:
        return (name, row), name

    def format_field(self, value: Any, spec: str) -> str:
        name, row = value
        if name not in row:
            return ""
        number = row[name]
        if spec == "±":
            return quoted(number, row.get(f"{name}_se"))
        if number is None:
            return "-"
        return f"1/{1 / number:g}" if spec == "1/" else format(number, spec)


def filled(template: str, row: dict) -> str:
    """The template with the columns of a row: `{p_star:.3g}`, `{kappa:±}`, `{eps_f:1/}`."""
    return _Filled().vformat(template, (), row)


def table(rows: Rows, columns: dict[str, str]) -> str:
    """A Markdown table; columns: {title: template of its cells}."""
    lines = [
        list(columns),
        *([filled(cell, row).replace("|", "\\|") for cell in columns.values()] for row in rows),
    ]
    head, *body = ("| " + " | ".join(line) + " |" for line in lines)
    return "\n".join([head, "|" + "---|" * len(columns), *body])


def literal(text: str) -> str:
    """Text in which an asterisk is an asterisk."""
    return text.replace("*", "\\*")
