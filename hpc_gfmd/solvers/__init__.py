"""One solver per file; `base.py` says what a solver is, `driver/drive.py` is the only loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..util.plugins import class_in, names_in

if TYPE_CHECKING:
    from .base import Solver

COMMON = ("base", "options")  # files that are no solver


def solver_names() -> list[str]:
    """Return the names of all solvers, without importing them."""
    return list(names_in(__name__, COMMON))


def solver_class(name: str) -> type[Solver]:
    """Return the solver class of a name; "auto" is the default solver."""
    return class_in(__name__, "bpx" if name == "auto" else name)
