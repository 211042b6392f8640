"""Observables: the numbers and arrays that are computed from a solved load, one idea per file.

A file of this folder may define

* OBSERVABLES = {name: Observable(function of a contact, meaning, unit)}. The function returns a
  number, or None, and then the number is left out of the result.
* ON_REQUEST = True if its observables take FFT pairs or passes over the fields, or the names of
  those that do. They are computed only if the scene names them.
* TOGETHER = {name: names of observables}: names that stand for several observables.
* DISTRIBUTIONS = {name: Distribution(function of a contact, meaning, units)}: arrays, always on
  request. They become the attributes NAME_ARRAY of a load step, one for each array.

base.py defines these classes and describes the other numbers of a load. A contact is a
contact.contact.Contact. Sums that several observables share are its cached properties, so that only
what is requested is computed. Numbers are in the scene's units.
"""

from collections.abc import Iterable
from functools import cache
from types import ModuleType
from typing import Any

from ..util.errors import SceneError
from ..util.plugins import module_in, names_in
from .base import OF_EVERY_LOAD, Distribution, Observable

COMMON = ("base", "contact", "fields", "notes")  # no observable


def all_observables() -> dict[str, Observable]:
    """Return {name: Observable} of this package and of plugins, which is kept: do not change it."""
    return _merged("OBSERVABLES")


@cache
def default_observables() -> tuple[str, ...]:
    """Return the names of the observables that every result has, those not ON_REQUEST."""
    names: list[str] = []
    for module in _observables():
        observables = getattr(module, "OBSERVABLES", {})
        on_request = getattr(module, "ON_REQUEST", ())
        if on_request is True:
            on_request = observables
        names += [name for name in observables if name not in on_request]
    return tuple(names)


def observable_names() -> set[str]:
    """Return the names that a scene may request: of single observables and of groups (TOGETHER)."""
    return {*all_observables(), *_merged("TOGETHER")}


def observables_named(names: Iterable[str]) -> dict[str, Observable]:
    """Return {name: Observable} of known names, with those of groups (TOGETHER) expanded."""
    together = _merged("TOGETHER")
    members = {member for name in names for member in together.get(name, (name,))}
    observables = all_observables()
    return {name: observables[name] for name in observables if name in members}


def all_distributions() -> dict[str, Distribution]:
    """Return {name: Distribution} of this package and of plugins; the dict must not be changed."""
    return _merged("DISTRIBUTIONS")


def all_numbers() -> dict[str, tuple[str, str]]:
    """Return {name: (meaning, unit)} of all numbers and arrays (NAME_ARRAY) of a load."""
    counted = {
        f"{name}_{array}": (f"{distribution.meaning}; {array}", unit)
        for name, distribution in all_distributions().items()
        for array, unit in distribution.units.items()
    }
    observed = {
        name: (observable.meaning, observable.unit)
        for name, observable in all_observables().items()
    }
    return OF_EVERY_LOAD | observed | counted


def require_periodic(names: Iterable[str], free: tuple[bool, bool], key: str) -> None:
    """Raise SceneError if a distribution among the `names` of a key needs a periodic surface."""
    distributions = all_distributions()
    periodic = [name for name in distributions if distributions[name].periodic and any(free)]
    for name in names:
        if name in periodic:
            raise SceneError(
                f"{key}: found {name!r}, which needs periodic boundaries, allowed:"
                f" {', '.join(sorted(all_distributions().keys() - periodic))}"
            )


@cache
def _merged(table: str) -> dict[str, Any]:
    """Return the tables of one name, such as "OBSERVABLES", of all files as one dict."""
    return {
        name: entry
        for module in _observables()
        for name, entry in getattr(module, table, {}).items()
    }


@cache
def _observables() -> list[ModuleType]:
    """Import and return the modules that may define observables: of this folder and of plugins."""
    return [module_in(__name__, name) for name in names_in(__name__, COMMON)]
