"""Solvers, observables and elastic bodies are found by looking into their folders: adding one means dropping in one file."""

import importlib
import pkgutil

from . import bodies, observables, solvers
from .errors import SceneError

COMMON = {"base"}  # files in those folders that are not entries


def _names(package):
    return sorted(m.name for m in pkgutil.iter_modules(package.__path__) if m.name not in COMMON)


def solver_names():
    """Names of all solvers, without importing them."""
    return _names(solvers)


def solver_class(name):
    """The solver class of a name; "auto" is the default solver."""
    name = "bpx" if name == "auto" else name
    module = importlib.import_module(f"{solvers.__name__}.{name}")
    return next(c for c in vars(module).values() if isinstance(c, type) and c.__dict__.get("name") == name)


def body_classes():
    """{name: class} of all elastic bodies."""
    modules = {name: importlib.import_module(f"{bodies.__name__}.{name}") for name in _names(bodies)}
    return {name: next(c for c in vars(module).values() if isinstance(c, type) and c.__dict__.get("name") == name)
            for name, module in modules.items()}


def body_of(material, free=(False, False)):
    """The elastic body of scene.Material; free: whether the surface ends along x, along y. Raises SceneError if there is none."""
    wanted = material.thickness, material.nu1, material.base, tuple(free)
    bodies_ = [body for cls in body_classes().values() if (body := cls.of(*wanted)) is not None]
    if not bodies_:
        raise SceneError(f"material.thickness: found {material.thickness:g} with a free boundary, allowed: with periodic boundaries")
    return bodies_[0]


def all_observables():
    """{name: function of a Contact} of all observables, those of one file in the order they are given there."""
    return {name: f for module in _observables() for name, f in module.OBSERVABLES.items()}


def default_observables():
    """Names of the observables that cost no FFT: what a result has where the scene names none."""
    return [name for module in _observables() if not getattr(module, "ON_REQUEST", False) for name in module.OBSERVABLES]


def _observables():
    return [importlib.import_module(f"{observables.__name__}.{name}") for name in _names(observables)]
