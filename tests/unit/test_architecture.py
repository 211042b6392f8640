"""What may import what, read from the source: numba and MPI in their folders, layers in one
direction, small files."""

import ast
from pathlib import Path

import pytest

import hpc_gfmd

ROOT = Path(hpc_gfmd.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
LONGEST = 560  # lines

ALLOWED_IN = {  # module: folders or files that may import it
    "numba": ("kernels/", "commands/info.py"),
    "mpi4py": ("parallel/", "commands/info.py"),
    "mpi4py_fft": ("parallel/",),
    "matplotlib": ("plotting/",),
}
TOP = (
    "composition",
    "simulation",
    "prepared",
    "restored",
    "solution",
    "solutions",
    "keywords",
    "api",
    "commands",
    "cli",
)  # what composes all the rest
FORBIDDEN = {  # folder: parts of the package that it must not know
    "theory/": (
        "scene",
        "grid",
        "parallel",
        "kernels",
        "solvers",
        "driver",
        "output",
        "surface",
        "observables",
        "plotting",
        *TOP,
    ),
    "scene/": (
        "grid",
        "parallel",
        "kernels",
        "solvers",
        "driver",
        "output",
        "surface",
        "observables",
        "plotting",
        *TOP,
        "theory",
    ),
    "kernels/": (
        "scene",
        "grid",
        "parallel",
        "solvers",
        "driver",
        "output",
        "surface",
        "observables",
        "plotting",
        *TOP,
        "theory",
    ),
    "parallel/": (
        "scene",
        "grid",
        "solvers",
        "driver",
        "output",
        "surface",
        "observables",
        "plotting",
        *TOP,
        "theory",
    ),
    "bodies/": (
        "scene",
        "solvers",
        "driver",
        "output",
        "surface",
        "observables",
        "plotting",
        *TOP,
        "theory",
    ),
    "surface/": ("solvers", "driver", "output", "observables", "plotting", *TOP, "theory"),
    "solvers/": ("scene", "surface", "driver", "output", "observables", "plotting", *TOP, "theory"),
    "observables/": ("scene", "solvers", "driver", "output", "plotting", *TOP, "theory"),
    "output/": ("solvers", "kernels", "driver", "surface", "observables", "plotting", *TOP),
    "plotting/": ("solvers", "kernels", "driver", "surface", "observables", *TOP, "grid"),
}
HEAVY = ("numpy", "scipy", "h5py", "numba", "matplotlib")  # not for the scene


def imports(path):
    """Full names of all modules that a file imports anywhere in it."""
    package = ["hpc_gfmd", *path.relative_to(ROOT).parts[:-1]]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            stem = ".".join([*base, *([node.module] if node.module else [])])
            yield stem
            yield from (f"{stem}.{alias.name}" for alias in node.names)


def name(path):
    return path.relative_to(ROOT).as_posix()


def test_the_rules_are_about_what_there_is():
    modules = {path.stem if path.is_file() else path.name for path in ROOT.iterdir()}
    for place in (*FORBIDDEN, *(place for places in ALLOWED_IN.values() for place in places)):
        assert (ROOT / place).exists(), place
    for part in {part for parts in FORBIDDEN.values() for part in parts}:
        assert part in modules, part
    everything = set().union(*map(set, map(imports, FILES)))
    assert all(
        any(found.partition(".")[0] == module for found in everything) for module in ALLOWED_IN
    )


@pytest.mark.parametrize("path", FILES, ids=name)
def test_file(path):
    here, found = name(path), set(imports(path))
    for module, places in ALLOWED_IN.items():
        if any(f == module or f.startswith(module + ".") for f in found):
            assert here.startswith(places), f"{here} imports {module}"
    for folder, parts in FORBIDDEN.items():
        if here.startswith(folder):
            wrong = {
                f
                for f in found
                for part in parts
                if f == f"hpc_gfmd.{part}" or f.startswith(f"hpc_gfmd.{part}.")
            }
            assert not wrong, f"{here} imports {wrong}"
    if here.startswith("scene/"):
        assert not {f for f in found if f.partition(".")[0] in HEAVY}
    assert len(path.read_text().splitlines()) <= LONGEST


def test_only_bodies_know_a_stiffness():
    """Whoever needs a step length, a weight or a bound asks the body: no other file looks at the
    shortest wave or multiplies by |q|."""
    words = (
        "q_nyquist",
        "multiply_stiffness",
        "multiply_compliance",
        "_by_table",
        "halfspace.HalfSpace",
    )
    places = ("bodies/", "kernels/spectral.py", "operators/coarsening.py", "grid.py")
    knowing = {name(path) for path in FILES if any(word in path.read_text() for word in words)}
    assert not {f for f in knowing if not f.startswith(places)}
    assert any(f.startswith("bodies/") for f in knowing)
