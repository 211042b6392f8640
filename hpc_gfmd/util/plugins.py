"""What lies in a folder of drop-in files: a body, a solver or an observable is added as a file."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable
from typing import Any


def names_in(package: str, apart: Iterable[str] = ("base",)) -> list[str]:
    """List the drop-in files of a package without importing them; apart: its other files."""
    path = importlib.import_module(package).__path__
    return sorted(module.name for module in pkgutil.iter_modules(path) if module.name not in apart)


def class_in(package: str, name: str) -> Any:
    """Find the class of a drop-in file whose `name` is the file's."""
    module = importlib.import_module(f"{package}.{name}")
    return next(
        c for c in vars(module).values() if isinstance(c, type) and c.__dict__.get("name") == name
    )
