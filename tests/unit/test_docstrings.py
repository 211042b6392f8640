"""Public functions, classes and methods have numpydoc docstrings (numpydoc.validate).

Public names have no leading underscore.
"""

import dataclasses
import importlib
import inspect
import pkgutil

import pytest
from numpydoc.docscrape import get_doc_object
from numpydoc.validate import validate
from pydantic import BaseModel

import hpc_gfmd

RULES = {
    "GL08",  # there is a docstring
    "SS05",  # the summary of a function begins with an imperative: Return, not Returns
    "PR01",  # all parameters are documented
    "PR02",  # and no others
    "RT01",  # what is returned is documented
}
MODULES = [
    module.name
    for module in pkgutil.walk_packages(hpc_gfmd.__path__, "hpc_gfmd.")
    if not module.name.endswith("__main__")
]


def public(module):
    """(name, object) of all functions, classes and methods that a module defines."""
    for name, entry in list(vars(module).items()):  # a module may load more as it is read
        function = getattr(entry, "py_func", entry)  # of a kernel
        if name.startswith("_") or getattr(function, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(function):
            yield name, function
        elif inspect.isclass(entry):
            yield name, entry
            for method, value in vars(entry).items():
                function = getattr(value, "__func__", value)
                if not inspect.isfunction(function) or function.__module__ != module.__name__:
                    continue  # matplotlib adds methods of its own
                if not method.startswith("_") or (method == "__init__" and function.__doc__):
                    yield f"{name}.{method}", function


def fields(entry):
    """Names of the fields of a record that its Attributes section has to explain."""
    if dataclasses.is_dataclass(entry):
        own = vars(entry).get("__annotations__", ())  # its base class explains the others
        return [f.name for f in dataclasses.fields(entry) if f.name[0] != "_" and f.name in own]
    return list(getattr(entry, "_fields", ()))


def is_short(entry):
    """Whether a function takes at most one argument, which its summary can explain."""
    try:
        names = inspect.signature(entry).parameters.keys() - {"self", "cls"}
    except (TypeError, ValueError):
        return False
    return len(names) <= 1


def is_override(module, name):
    """Whether a method takes the place of one of a base class, which explains its arguments."""
    class_name, _, method = name.partition(".")
    bases = getattr(module, class_name).__mro__[1:] if method and method != "__init__" else ()
    return any(method in vars(base) for base in bases)


def mistakes(module, name, entry):
    """Problems of the docstring of one object."""
    path = f"{module.__name__}.{name}"
    record = fields(entry) if inspect.isclass(entry) else []
    exempt = set()
    if inspect.isclass(entry) and ("__init__" not in vars(entry) or entry.__init__.__doc__):
        exempt.add("PR01")  # there are none, or `__init__` explains them
    if name.endswith("__init__"):
        exempt.add("SS05")
    is_explained = is_short(entry) or is_override(module, name) or record
    if is_explained or (inspect.isclass(entry) and issubclass(entry, BaseModel)):
        exempt |= {"PR01", "RT01"}
    if record or inspect.isclass(entry):
        exempt |= {"PR02", "RT01", "SS05"}
    for code, message in validate(get_doc_object(entry))["errors"]:
        if code in RULES - exempt:
            yield f"{path}: {message}"
    if len(record) > 1:
        explained = {
            part.strip()
            for entry_ in get_doc_object(entry)["Attributes"]
            for part in entry_.name.split(",")
        }
        if missing := [field for field in record if field not in explained]:
            yield f"{path}: fields without a line under Attributes: {missing}"


@pytest.mark.parametrize("name", MODULES)
def test_public_docstrings(name):
    module = importlib.import_module(name)
    problems = [line for entry in public(module) for line in mistakes(module, *entry)]
    assert not problems, "\n".join(problems)
