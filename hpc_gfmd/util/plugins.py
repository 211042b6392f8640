"""Drop-in files: a body, solver, observable or law is a file in its folder, or of another package
with an entry point, as "hpc_gfmd.bodies": {"graded": "extra.graded"}.
"""

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
    """List drop-in files, other packages' first, unimported; apart: files that are none."""
    path = importlib.import_module(package).__path__
    files = {module.name for module in pkgutil.iter_modules(path)}
    return (*sorted(_added(package).keys() - files), *sorted(files - {*apart}))


@cache
def module_in(package: str, name: str) -> Any:
    """Import a drop-in file; GfmdError if that of another package fails, ImportError otherwise."""
    point = _added(package).get(name)
    if point is None:
        return importlib.import_module(f"{package}.{name}")
    try:
        return point.load()
    except Exception as error:
        raise GfmdError(f"{point.group}: {name} = {point.value} does not load: {error}") from error


@cache
def class_in(package: str, name: str) -> Any:
    """Return the class of a drop-in file whose `name` is that of the file, or raise GfmdError."""
    for value in vars(module_in(package, name)).values():
        if isinstance(value, type) and vars(value).get("name") == name:
            return value
    raise GfmdError(f'{package}: {name} has no class with name = "{name}"')


def sources_added(package: str) -> list[Path]:
    """Return the paths of the drop-in files of other packages, without importing them."""
    names = sorted(point.value.partition(":")[0] for point in _added(package).values())
    specs = [find_spec(name) for name in names]
    return [Path(spec.origin) for spec in specs if spec is not None and spec.origin]


@cache
def _added(package: str) -> dict[str, EntryPoint]:
    """Return other packages' entry points by name ("hpc_gfmd.observables" for hpc_gfmd.contact);
    cached, do not change.
    """
    group = package.replace("contact", "observables")
    return {point.name: point for point in entry_points(group=group)}
