"""Rules of imports, read from the source: folders import from lower floors only, without cycles;
numba, MPI and matplotlib are imported by few folders; files are short."""

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

import hpc_gfmd

ROOT = Path(hpc_gfmd.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
LONGEST = 510  # lines
FLOORS = (  # from the top; a folder imports from lower floors and from itself
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
HEAVY = ("numpy", "scipy", "h5py", "numba", "matplotlib")  # not imported by scene/
LEVEL = {folder: -k for k, floor in enumerate(FLOORS) for folder in floor}


def imports(path):
    """Full names of everything that a file imports, including imports for type checkers."""
    package = ["hpc_gfmd", *path.relative_to(ROOT).parts[:-1]]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            stem = ".".join([*base, *([node.module] if node.module else [])])
            yield from (f"{stem}.{alias.name}" for alias in node.names)


def imported(path, modules):
    """The given modules that a file imports, or imports names from."""
    names = {f if f in modules else f.rpartition(".")[0] for f in imports(path)}
    return names & modules - {module(path)}


def name(path):
    return path.relative_to(ROOT).as_posix()


def module(path):
    parts = ["hpc_gfmd", *path.relative_to(ROOT).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_rules_cover_all_folders():
    folders = {path.name for path in ROOT.iterdir() if (path / "__init__.py").exists()}
    assert folders == {folder for floor in FLOORS for folder in floor}
    packages = {entry.partition(".")[0] for path in FILES for entry in imports(path)}
    assert packages >= set(ALLOWED_IN)
    assert len([path for path in ROOT.iterdir() if path.is_file()]) <= 8


def broken_rules(path):
    """What a file imports although its folder must not, and whether it is too long."""
    folder = name(path).partition("/")[0]
    for entry in set(imports(path)):
        library, *inside = entry.split(".")
        if library in ALLOWED_IN and not name(path).startswith(ALLOWED_IN[library]):
            yield f"{name(path)} imports {library}"
        if library in HEAVY and folder == "scene":
            yield f"{name(path)} imports {library}, which takes long"
        other = inside[0] if library == "hpc_gfmd" and inside else None
        if {folder, other} <= set(LEVEL) and other != folder and LEVEL[other] >= LEVEL[folder]:
            yield f"{name(path)} imports {other}, which is not below it"
    if len(path.read_text().splitlines()) > LONGEST:
        yield f"{name(path)} has more than {LONGEST} lines"


def test_imports_and_length_of_files():
    assert [rule for path in FILES for rule in broken_rules(path)] == []


def test_no_import_cycles():
    modules = {module(path) for path in FILES}
    graph = {module(path): imported(path, modules) for path in FILES}
    TopologicalSorter(graph).prepare()  # raises CycleError, which names the modules


def test_only_bodies_depend_on_the_stiffness():
    """Step lengths, weights and bounds come from the body: other files neither use the shortest
    wave nor multiply by |q|."""
    words = ("q_nyquist", "_multiply_by_q", "_by_table", "halfspace.HalfSpace")
    places = ("bodies/", "kernels/spectral.py", "parallel/coarsening.py", "parallel/grid.py")
    using = {name(path) for path in FILES if any(word in path.read_text() for word in words)}
    assert not {file_name for file_name in using if not file_name.startswith(places)}
    assert any(file_name.startswith("bodies/") for file_name in using)


def test_names_on_the_developer_page_exist():
    """Files, and functions and classes in them."""
    page = (ROOT.parent / "docs" / "developer.md").read_text()
    mentioned = re.findall(r"`([\w/]+\.py)(?:: ([\w., ]+))?`", page)
    assert mentioned
    for file, names in mentioned:
        places = [path for path in (ROOT / file, ROOT.parent / file) if path.exists()]
        assert places, file
        for word in re.findall(r"\w+", names):
            assert re.search(rf"(def|class) {word}\b", places[0].read_text()), word
