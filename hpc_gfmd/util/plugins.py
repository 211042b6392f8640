"""What lies in a folder of drop-in files: a body, a solver or an observable is added as a file."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence
from functools import cache
from typing import Any


@cache
def names_in(package: str, apart: Sequence[str] = ("base",)) -> Sequence[str]:
    """List the drop-in files of a package without importing them; apart: its other files."""
    path = importlib.import_module(package).__path__
    names = (module.name for module in pkgutil.iter_modules(path))
    return tuple(sorted(name for name in names if name not in apart))


@cache
def class_in(package: str, name: str) -> Any:
    """Find the class of a drop-in file whose `name` is the file's."""
    module = importlib.import_module(f"{package}.{name}")
    return next(
        c for c in vars(module).values() if isinstance(c, type) and c.__dict__.get("name") == name
    )
