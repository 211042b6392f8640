"""What lies in a folder of drop-in files: a body, a solver or an observable is added as a file, or
as such a file of another package by an entry point, such as
"hpc_gfmd.bodies": {"graded": "gfmd_extra.graded"}."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .errors import GfmdError


@cache
def names_in(package: str, apart: Sequence[str]) -> Sequence[str]:
    """List what other packages add to a folder, then its drop-in files, without importing them;
    apart: its other files."""
    path = importlib.import_module(package).__path__
    own = {module.name for module in pkgutil.iter_modules(path)}
    return (*sorted(_added(package).keys() - own), *sorted(own - {*apart}))


@cache
def module_in(package: str, name: str) -> Any:
    """Import the file of this name. Raises GfmdError for one of another package that fails."""
    point = _added(package).get(name)
    if point is None:
        return importlib.import_module(f"{package}.{name}")
    try:
        return point.load()
    except Exception as error:
        raise GfmdError(f"{point.group}: {name} = {point.value} does not load: {error}") from error


@cache
def class_in(package: str, name: str) -> Any:
    """Find the class of a drop-in file whose `name` is the file's. Raises GfmdError without one."""
    for found in vars(module_in(package, name)).values():
        if isinstance(found, type) and vars(found).get("name") == name:
            return found
    raise GfmdError(f'{package}: {name} has no class with name = "{name}"')


def sources_added(package: str) -> list[Path]:
    """List the files that other packages add to a folder, without importing them."""
    names = sorted(point.value.partition(":")[0] for point in _added(package).values())
    found = [find_spec(name) for name in names]
    return [Path(spec.origin) for spec in found if spec is not None and spec.origin]


@cache
def _added(package: str) -> dict[str, EntryPoint]:
    group = package.replace("contact", "observables")
    return {point.name: point for point in entry_points(group=group)}
