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
    """List the names of a folder's drop-in files, and of those that other packages add to it.

    None of the files is imported.

    Parameters
    ----------
    package : str
        The folder as a package, such as "hpc_gfmd.bodies".
    apart : tuple of str
        Names of files in the folder that are not drop-in files. Not a list: results are cached.

    Returns
    -------
    sequence of str
        First the names that other packages add, then those in the folder, each in alphabetical
        order.
    """
    path = importlib.import_module(package).__path__
    files = {module.name for module in pkgutil.iter_modules(path)}
    return (*sorted(_added(package).keys() - files), *sorted(files - {*apart}))


@cache
def module_in(package: str, name: str) -> Any:
    """Import and return a drop-in file.

    Parameters
    ----------
    package : str
        The folder as a package, such as "hpc_gfmd.bodies".
    name : str
        Name of the file, as `names_in` lists it.

    Returns
    -------
    module
        The imported file.

    Raises
    ------
    GfmdError
        If a file of another package cannot be imported.
    ImportError
        If there is no file of this name, or a file in the folder cannot be imported.
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
    """Import a drop-in file and return its class: the one whose `name` is the name of the file.

    Parameters
    ----------
    package : str
        The folder as a package, such as "hpc_gfmd.bodies".
    name : str
        Name of the file, as `names_in` lists it.

    Returns
    -------
    type
        The class.

    Raises
    ------
    GfmdError
        If the file has no such class, or a file of another package cannot be imported.
    """
    for value in vars(module_in(package, name)).values():
        if isinstance(value, type) and vars(value).get("name") == name:
            return value
    raise GfmdError(f'{package}: {name} has no class with name = "{name}"')


def sources_added(package: str) -> list[Path]:
    """Return the paths of the drop-in files that other packages add to a folder.

    The files are not imported, only the packages that contain them.
    """
    names = sorted(point.value.partition(":")[0] for point in _added(package).values())
    specs = [find_spec(name) for name in names]
    return [Path(spec.origin) for spec in specs if spec is not None and spec.origin]


@cache
def _added(package: str) -> dict[str, EntryPoint]:
    """Return the entry points, by name, with which other packages add files to a folder.

    Their group is named as the package, but "hpc_gfmd.observables" for hpc_gfmd.contact. The dict
    is cached and must not be changed.
    """
    group = package.replace("contact", "observables")
    return {point.name: point for point in entry_points(group=group)}
