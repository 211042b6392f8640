"""What users and plug-ins call has numpydoc docstrings (numpydoc.validate); all that has no leading
underscore has a docstring.
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

# beside hpc_gfmd.__all__: bases of drop-in files, and modules that pages name; (): all of a module
OTHERS = {
    "bodies.base": (),
    "laws.base": ("Law", "Numbers"),
    "solvers.base": (),
    "contact.base": (),
    "contact.contact": ("Contact",),
    "theory.persson": (),
    "theory.elastic": (),
    "theory.adhesion": (),
    "theory.leak": (),
    "theory.tfc": ("Correction", "correction", "extrapolate"),
    "theory.reference": (),
}
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


def face():
    """{module: names of what users and plug-ins call; none for all}."""
    called = {f"hpc_gfmd.{module}": names for module, names in OTHERS.items()}
    for name in hpc_gfmd.__all__:
        entry = getattr(hpc_gfmd, name)
        if inspect.isfunction(entry) or inspect.isclass(entry):
            called[entry.__module__] = (*called.get(entry.__module__, ()), entry.__name__)
    return called


@pytest.mark.parametrize("path", face())
def test_what_is_called_is_explained(path):
    names = face()[path]
    module = importlib.import_module(path)
    problems = [
        line
        for name, entry in public(module)
        if not names or name.partition(".")[0] in names
        for line in mistakes(module, name, entry)
    ]
    assert not problems, "\n".join(problems)


def test_all_public_names_have_a_docstring():
    modules = map(importlib.import_module, MODULES)
    missing = [
        f"{module.__name__}.{name}"
        for module in modules
        for name, entry in public(module)
        if not inspect.getdoc(entry)
    ]
    assert not missing, missing
