"""Solvers, observables and elastic bodies are found by looking into their folders: adding one means
dropping in one file."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any

from . import bodies, observables, solvers
from .errors import SceneError
from .observables.base import OF_EVERY_LOAD
from .quantity import in_units, said

if TYPE_CHECKING:
    from .bodies.base import Body
    from .contact import Contact
    from .observables.base import Arrays, Distribution, Observable
    from .scene import Material
    from .solvers.base import Solver

COMMON = {"base"}  # files in those folders that are not entries


def _names(package: ModuleType) -> list[str]:
    return sorted(m.name for m in pkgutil.iter_modules(package.__path__) if m.name not in COMMON)


def _class(package: ModuleType, name: str) -> Any:
    """The class of a file whose `name` is the file's."""
    module = importlib.import_module(f"{package.__name__}.{name}")
    return next(
        c for c in vars(module).values() if isinstance(c, type) and c.__dict__.get("name") == name
    )


def solver_names() -> list[str]:
    """Names of all solvers, without importing them."""
    return _names(solvers)


def solver_class(name: str) -> type[Solver]:
    """The solver class of a name; "auto" is the default solver."""
    return _class(solvers, "bpx" if name == "auto" else name)


def body_classes() -> dict[str, type[Body]]:
    """{name: class} of all elastic bodies."""
    return {name: _class(bodies, name) for name in _names(bodies)}


def body_of(material: Material, free: tuple[bool, bool] = (False, False)) -> Body:
    """The elastic body that a material (scene.Material) means; free: whether the surface ends along
    x, along y.

    Raises SceneError if there is none.
    """
    wanted = material.thickness, material.nu1, material.base, tuple(free)
    bodies_ = [body for cls in body_classes().values() if (body := cls.of(*wanted)) is not None]
    if not bodies_:
        thickness = said(material.thickness)
        raise SceneError(
            f"material.thickness: found {thickness} with a free boundary, allowed: with periodic"
            " boundaries"
        )
    return bodies_[0]


def all_observables() -> dict[str, Observable]:
    """{name: Observable}, those of one file in the order they are given there."""
    return _merged("OBSERVABLES")


def default_observables() -> list[str]:
    """Names of the observables that cost no more than a look at each point: every result has
    them."""
    return [
        name
        for module in _observables()
        if not getattr(module, "ON_REQUEST", False)
        for name in getattr(module, "OBSERVABLES", ())
    ]


def observable_names() -> set[str]:
    """What a scene may ask for: names of observables, and names that stand for several of them."""
    return {*all_observables(), *_merged("TOGETHER")}


def names_together(name: str) -> tuple[str, ...]:
    """The observables that a name stands for where it stands for several, otherwise none."""
    return _merged("TOGETHER").get(name, ())


def observables_named(names: Iterable[str]) -> dict[str, Observable]:
    """{name: Observable} of those that these names stand for."""
    together = _merged("TOGETHER")
    wanted = {one for name in names for one in together.get(name, (name,))}
    return {name: f for name, f in all_observables().items() if name in wanted}


def all_distributions() -> dict[str, Distribution]:
    """{name: Distribution} of all of them."""
    return _merged("DISTRIBUTIONS")


def all_numbers() -> dict[str, tuple[str, str]]:
    """{name: (meaning, unit)} of all that a result may have of a load, distributions included; for
    units see observables/base.py."""
    counted = {
        f"{name}_{what}": (f"{one.meaning}; {what}", unit)
        for name, one in all_distributions().items()
        for what, unit in one.units.items()
    }
    observed = {name: (one.meaning, one.unit) for name, one in all_observables().items()}
    return OF_EVERY_LOAD | observed | counted


def meaning_of(name: str) -> str:
    """Return what the number of this name means; "" for a name that is not known."""
    return all_numbers().get(name, ("", ""))[0]


def unit_of(name: str, surface: Mapping[str, Any]) -> str:
    """Return the unit of the number of this name: "Pa/m". surface: the attributes of a result's.

    "1": dimensionless; "": nobody named the unit, or the number is not known.
    """
    return in_units(all_numbers()[name][1], surface) if name in all_numbers() else ""


def distribution_names(free: tuple[bool, bool] = (False, False)) -> set[str]:
    """What a scene may ask for; free: whether the surface ends along x, along y."""
    fit = [
        module
        for module in _observables()
        if not (any(free) and getattr(module, "PERIODIC", False))
    ]
    return {name for module in fit for name in getattr(module, "DISTRIBUTIONS", ())}


def require_periodic(names: Iterable[str], free: tuple[bool, bool], key: str) -> None:
    """Raise SceneError where a distribution by one of these names needs periodic boundaries; free:
    whether the surface ends along x, along y; key: where the names stand."""
    known = distribution_names(free)
    for name in names:
        if name in distribution_names() - known:
            raise SceneError(
                f"{key}: found {name!r}, which needs periodic boundaries, allowed:"
                f" {', '.join(sorted(known))}"
            )


def distributions_named(names: Iterable[str], contact: Contact) -> dict[str, Arrays]:
    """{name: {what: array of numbers}} of the distributions of a contact by these names that have
    anything to count. Collective."""
    found = {name: f(contact) for name, f in all_distributions().items() if name in names}
    return {name: arrays for name, arrays in found.items() if arrays is not None}


def _merged(table: str) -> dict[str, Any]:
    return {
        name: entry
        for module in _observables()
        for name, entry in getattr(module, table, {}).items()
    }


def _observables() -> list[ModuleType]:
    return [
        importlib.import_module(f"{observables.__name__}.{name}") for name in _names(observables)
    ]
