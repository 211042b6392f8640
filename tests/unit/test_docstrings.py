"""Whatever users and authors of extensions meet says what it is, and what each of its arguments
is."""

import inspect
import re

import pytest

import hpc_gfmd
from hpc_gfmd import bodies, contact, solvers
from hpc_gfmd.bodies.base import Body, Multipliers
from hpc_gfmd.certificate.certificate import Certificate
from hpc_gfmd.contact.contact import Contact
from hpc_gfmd.solvers.base import Progress, Solver
from hpc_gfmd.theory import elastic, persson, reference, tfc

MODULES = {
    hpc_gfmd: hpc_gfmd.__all__,
    reference: reference.__all__,
    tfc: tfc.__all__,
    bodies: None,
    contact: None,
    solvers: None,
    persson: None,
    elastic: None,
}
EXTENSIONS = (Body, Multipliers, Solver, Progress, Contact, Certificate)


def _public():
    """(name, function or class) of all of them, methods included."""
    entries = {entry.__qualname__: entry for entry in EXTENSIONS}
    for module, names in MODULES.items():
        names = names or [
            name
            for name, entry in vars(module).items()
            if getattr(entry, "__module__", None) == module.__name__
        ]
        entries |= {
            f"{module.__name__}.{name}": getattr(module, name)
            for name in names
            if not name.startswith("_")
        }
    for name, entry in list(entries.items()):
        if inspect.isclass(entry):
            methods = {
                method: own for method, own in vars(entry).items() if not method.startswith("_")
            }
            entries |= {
                f"{name}.{method}": own
                for method, own in methods.items()
                if inspect.isfunction(own) or isinstance(own, property | classmethod)
            }
    return {
        name: entry
        for name, entry in entries.items()
        if callable(entry) or isinstance(entry, property | classmethod)
    }


PUBLIC = _public()


@pytest.mark.parametrize("name", PUBLIC)
def test_says_what_it_is(name):
    entry = PUBLIC[name]
    own = entry.__func__ if isinstance(entry, classmethod) else entry
    text = inspect.getdoc(own) or ""
    assert len(text.split()) > 1, f"{name} has no docstring"
    if inspect.isfunction(own) and "." not in own.__qualname__:  # a function of a module
        for argument in inspect.signature(own).parameters:
            assert re.search(rf"\b{re.escape(argument)}\b", text), (
                f"{name} does not say what {argument} is"
            )


@pytest.mark.parametrize("module", [hpc_gfmd, reference, tfc])
def test_functions_are_in_the_form_of_numpydoc(module):
    """With the sections that a page is generated from."""
    for name in module.__all__:
        function = getattr(module, name)
        if inspect.isfunction(function) and len(inspect.signature(function).parameters) > 1:
            text = inspect.getdoc(function)
            assert all(
                f"{section}\n{'-' * len(section)}\n" in text
                for section in ("Parameters", "Returns", "Raises")
            ), name
