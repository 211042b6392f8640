"""A solved load and its observables, one idea per file: OBSERVABLES = {name: Observable(function of
a contact, meaning, unit)}. A function returns a number, or None, which is left out of the result.

ON_REQUEST = True marks a file whose observables take FFT pairs or passes over the fields of their
own: only where the scene names them. TOGETHER = {name: names of observables} has names that stand
for several. DISTRIBUTIONS = {name: Distribution(function of a contact, meaning, units)}, always on
request, becomes the attributes NAME_WHAT of a load step. base.py has these classes, and what is
said of the other numbers of a load.

`contact` is a contact.contact.Contact; sums that several observables share are its cached
properties, so that only what is requested is computed. Numbers are in the scene's units.
"""

from collections.abc import Iterable
from functools import cache
from types import ModuleType
from typing import Any

from ..util.errors import SceneError
from ..util.plugins import module_in, names_in
from .base import OF_EVERY_LOAD, Distribution, Observable

COMMON = ("base", "contact", "notes", "attraction_notes", "other_branch")  # no observable


def all_observables() -> dict[str, Observable]:
    """Return {name: Observable}, those of one file in the order they are given there."""
    return _merged("OBSERVABLES")


def default_observables() -> list[str]:
    """Return the names of the observables that cost no more than a look at each point: every result
    has them."""
    return [
        name
        for module in _observables()
        if not getattr(module, "ON_REQUEST", False)
        for name in getattr(module, "OBSERVABLES", ())
    ]


def observable_names() -> set[str]:
    """Return what a scene may ask for: names of observables, and names that stand for several of
    them."""
    return {*all_observables(), *_merged("TOGETHER")}


def observables_named(names: Iterable[str]) -> dict[str, Observable]:
    """Return {name: Observable} of those that these names stand for."""
    together = _merged("TOGETHER")
    members = {member for name in names for member in together.get(name, (name,))}
    observables = all_observables()
    return {name: observables[name] for name in observables if name in members}


def all_distributions() -> dict[str, Distribution]:
    """Return {name: Distribution} of all of them."""
    return _merged("DISTRIBUTIONS")


def all_numbers() -> dict[str, tuple[str, str]]:
    """Return {name: (meaning, unit)} of all that a result may have of a load, distributions
    included; for units see base.py."""
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
    """Raise SceneError where a distribution needs periodic boundaries and the surface has others.

    Parameters
    ----------
    names : iterable of str
        Distributions that are asked for.
    free : (bool, bool)
        Whether the surface has free edges along x, along y.
    key : str
        Where the names stand, for the message.
    """
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
    """Return a table of this name, such as OBSERVABLES, of all files together."""
    return {
        name: entry
        for module in _observables()
        for name, entry in getattr(module, table, {}).items()
    }


@cache
def _observables() -> list[ModuleType]:
    """Return the modules of this folder and of plugins that define observables."""
    return [module_in(__name__, name) for name in names_in(__name__, COMMON)]
