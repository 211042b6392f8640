"""One solver per file; `base.py` says what a solver is, `driver/drive.py` is the only loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..util.plugins import class_in, names_in

if TYPE_CHECKING:
    from .base import Solver

COMMON = ("base", "options")  # files of this folder without a solver


def solver_names() -> list[str]:
    """List the names of all solvers, including those of other packages, without importing them."""
    return list(names_in(__name__, COMMON))


def solver_class(name: str) -> type[Solver]:
    """Import the file of a solver ("auto": bpx) and return its class, or raise GfmdError."""
    return class_in(__name__, "bpx" if name == "auto" else name)
