"""Drop-in files: a body, a solver, an observable or a law is a file in its folder, or a file of
another package with an entry point such as "hpc_gfmd.bodies": {"graded": "extra.graded"}."""

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
    """List the names of drop-in files, those that other packages add first; none is imported.

    package: the folder, such as "hpc_gfmd.bodies"; apart: files in it that are not drop-in files.
    """
    path = importlib.import_module(package).__path__
    files = {module.name for module in pkgutil.iter_modules(path)}
    return (*sorted(_added(package).keys() - files), *sorted(files - {*apart}))


@cache
def module_in(package: str, name: str) -> Any:
    """Import and return a drop-in file.

    Raises GfmdError if a file of another package cannot be imported, ImportError otherwise.
    """
    point = _added(package).get(name)
    if point is None:
        return importlib.import_module(f"{package}.{name}")
    try:
        return point.load()
    except Exception as error:
        raise GfmdError(f"{point.group}: {name} = {point.value} does not load: {error}") from error


@cache
def class_in(package: str, name: str) -> Any:
    """Import a drop-in file; return the class whose `name` is that of the file, or raise
    GfmdError.
    """
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
    """Return the entry points, by name, with which other packages add files to a folder.

    Their group is named as the package, but "hpc_gfmd.observables" for hpc_gfmd.contact. Do not
    change the dict, which is cached.
    """
    group = package.replace("contact", "observables")
    return {point.name: point for point in entry_points(group=group)}
