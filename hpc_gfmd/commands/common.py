"""What several commands share: common arguments, numbers such as 1/1024, JSON."""

import json
from argparse import ArgumentParser
from typing import Any

# how shells complete the name of a file, in the form that shtab reads
FILES = {"bash": "_shtab_compgen_files", "zsh": "_files", "tcsh": "f"}


def add_file(parser: ArgumentParser, *names: str, **options: Any) -> None:
    """Add an argument that is the path of a file, which shells can complete."""
    action = parser.add_argument(*names, **options)
    action.complete = FILES  # type: ignore[attr-defined]


def add_result_file(parser: ArgumentParser) -> None:
    """Add the positional argument `file`, a result file."""
    add_file(parser, "file", metavar="OUT.h5", help="result file")


def add_overrides(parser: ArgumentParser, text: str) -> None:
    """Add the option --set, which may be repeated."""
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help=text)


def add_json(parser: ArgumentParser, instead_of: str) -> None:
    """Add the option --json."""
    parser.add_argument("--json", action="store_true", help=f"print JSON instead of {instead_of}")


def add_quiet(parser: ArgumentParser) -> None:
    """Add the option --quiet."""
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")


def number(text: str) -> float:
    """Convert a decimal number or a ratio such as 1/1024. Raises ValueError for other texts."""
    numerator, slash, denominator = text.partition("/")
    try:
        return float(numerator) / float(denominator) if slash else float(numerator)
    except ZeroDivisionError:
        raise ValueError(text) from None


def as_json(value: Any, indent: int | None = None) -> str:
    """Return a value as JSON: null for infinity and NaN, texts for other objects."""
    plain = json.loads(json.dumps(value, default=str), parse_constant=lambda _: None)
    return json.dumps(plain, indent=indent)
