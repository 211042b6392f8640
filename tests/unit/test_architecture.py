"""The order of the folders, read from the source: every import goes down it, none runs in a circle;
numba, MPI and matplotlib stay in their folders; files are small."""

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import hpc_gfmd

ROOT = Path(hpc_gfmd.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
LONGEST = 510  # lines
FLOORS = (  # from the top down: a folder imports from those below its own floor, and from itself
    ("commands",),
    ("runs",),
    ("driver",),
    ("solvers", "contact"),
    ("surface", "certificate"),
    ("operators", "plotting"),
    ("bodies", "laws", "output"),
    ("parallel",),
    ("kernels", "scene", "theory"),
    ("util",),
)
ALLOWED_IN = {  # module: folders or files that may import it
    "numba": ("kernels/",),
    "mpi4py": ("parallel/", "commands/info.py"),
    "matplotlib": ("plotting/",),
}
HEAVY = ("numpy", "scipy", "h5py", "numba", "matplotlib")  # not for the scene
LEVEL = {folder: -k for k, floor in enumerate(FLOORS) for folder in floor}


def imports(path):
    """Full names of all modules that a file imports anywhere in it, for type checkers included."""
    package = ["hpc_gfmd", *path.relative_to(ROOT).parts[:-1]]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            stem = ".".join([*base, *([node.module] if node.module else [])])
            yield from (f"{stem}.{alias.name}" for alias in node.names)


def imported(path, modules):
    """The modules among these that a file imports, or imports something from."""
    found = {f if f in modules else f.rpartition(".")[0] for f in imports(path)}
    return found & modules - {module(path)}


def name(path):
    return path.relative_to(ROOT).as_posix()


def module(path):
    parts = ["hpc_gfmd", *path.relative_to(ROOT).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_the_rules_are_about_what_there_is():
    folders = {path.name for path in ROOT.iterdir() if (path / "__init__.py").exists()}
    assert folders == {folder for floor in FLOORS for folder in floor}
    everything = set().union(*map(set, map(imports, FILES)))
    assert all(
        any(found.partition(".")[0] == module for found in everything) for module in ALLOWED_IN
    )
    assert len([path for path in ROOT.iterdir() if path.is_file()]) <= 8


@pytest.mark.parametrize("path", FILES)
def test_file(path):
    here, found = name(path), set(imports(path))
    for other, places in ALLOWED_IN.items():
        if any(f == other or f.startswith(other + ".") for f in found):
            assert here.startswith(places), f"{here} imports {other}"
    folder = here.partition("/")[0]
    ours = {f.split(".")[1] for f in found if f.startswith("hpc_gfmd.")} & set(LEVEL)
    if folder in LEVEL:
        wrong = {f for f in ours if LEVEL[f] >= LEVEL[folder] and f != folder}
        assert not wrong, f"{here} imports {wrong}, which is not below it"
    if here.startswith("scene/"):
        assert not {f for f in found if f.partition(".")[0] in HEAVY}
    assert len(path.read_text().splitlines()) <= LONGEST


def test_no_circle():
    modules = {module(path) for path in FILES}
    graph = {module(path): imported(path, modules) for path in FILES}
    TopologicalSorter(graph).prepare()  # raises CycleError, which names them


def test_only_bodies_know_a_stiffness():
    """Whoever needs a step length, a weight or a bound asks the body: no other file looks at the
    shortest wave or multiplies by |q|."""
    words = ("q_nyquist", "_multiply_by_q", "_by_table", "halfspace.HalfSpace")
    places = ("bodies/", "kernels/spectral.py", "parallel/coarsening.py", "parallel/grid.py")
    knowing = {name(path) for path in FILES if any(word in path.read_text() for word in words)}
    assert not {f for f in knowing if not f.startswith(places)}
    assert any(f.startswith("bodies/") for f in knowing)


def test_the_developers_page():
    """Its floors are these, and every file and name that it points to is there."""
    page = (ROOT.parent / "docs" / "developer.md").read_text()
    floors = page.partition("```text\n")[2].partition("```")[0].splitlines()
    folders = {folder for floor in FLOORS for folder in floor}
    drawn = [set(line[:22].split()) & folders for line in floors]
    assert drawn == [set(floor) for floor in FLOORS]
    chain = page.partition("## One solve")[2].partition("\n## ")[0]
    assert 10 < chain.count("\n| ") <= 22
    for file, names in re.findall(r"`([\w/]+\.py)(?:: ([\w., ]+))?`", page):
        places = [path for path in (ROOT / file, ROOT.parent / file) if path.exists()]
        assert places, file
        for word in re.findall(r"\w+", names):
            assert re.search(rf"(def|class) {word}\b", places[0].read_text()), word
