"""Pages made of the program: every scene key, every command, the Python API, the gallery of
examples/."""

import ast
import contextlib
import inspect
import io
import re
from pathlib import Path

import hpc_gfmd
from hpc_gfmd.commands.cli import COMMANDS, main

HERE = Path(__file__).parent
EXAMPLES, PICTURES = HERE.parent / "examples", HERE / "gallery"
MODULES = (  # beside hpc_gfmd.__all__: title, name, what it is
    (
        "Reference curves",
        "hpc_gfmd.reference",
        (
            "Contact areas and mean gaps of self-affine surfaces, with uncertainties, from the runs"
            " of [the study](../study/README.md)."
        ),
    ),
    (
        "Persson's theory",
        "hpc_gfmd.theory.persson",
        "NumPy and SciPy alone: nothing of it needs a solver.",
    ),
    ("Closed forms", "hpc_gfmd.theory.elastic", "What the tests compare solutions with."),
    (
        "Adhesive contacts",
        "hpc_gfmd.theory.adhesion",
        "Balls, waves, and when a rough wall sticks.",
    ),
)


def made():
    """Make all pages: {name: text}."""
    return {
        "scene": scene(),
        "observables": _printed("help", "observables", "--markdown"),
        "commands": commands(),
        "api": api(),
        "gallery": gallery(),
    }


def write(folder):
    """Write all pages into a folder; those that have not changed keep their date."""
    folder.mkdir(exist_ok=True)
    for name, text in made().items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def scene():
    """Take what `hpc-gfmd help scene --markdown` prints."""
    return _printed("help", "scene", "--markdown")


def commands():
    """Take what `--help` of every command prints."""
    sections = [
        f"## hpc-gfmd {name}\n\n```text\n{_printed(name, '--help').strip()}\n```\n"
        for name in COMMANDS
    ]
    about = (
        "Made of what `hpc-gfmd COMMAND --help` prints. `python -m hpc_gfmd` is the same program."
    )
    return f"# Commands\n\n{about}\n\n" + "\n".join(sections)


def _printed(*argv):
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.suppress(SystemExit):
        main(list(argv))
    assert out.getvalue(), f"hpc-gfmd {' '.join(argv)} printed nothing"
    return out.getvalue()


def api():
    """List everything in hpc_gfmd.__all__, and the modules beside it that are meant for users."""
    found = {name: getattr(hpc_gfmd, name) for name in hpc_gfmd.__all__}
    groups = {"Functions": "autofunction", "Results": "autoclass", "Errors": "autoexception"}
    lines = ["# Python", "", "`import hpc_gfmd` neither starts MPI nor compiles anything.", ""]
    for title, directive in groups.items():
        names = [name for name, value in found.items() if _directive(value) == directive]
        lines += [f"## {title}", ""] * bool(names)
        for name in names:
            members = ["   :members:"] * (directive == "autoclass")
            lines += ["```{eval-rst}", f".. {directive}:: hpc_gfmd.{name}", *members, "```", ""]
    for title, module, about in MODULES:
        lines += [
            f"## {title}",
            "",
            about,
            "",
            "```{eval-rst}",
            f".. automodule:: {module}",
            "   :members:",
            "```",
            "",
        ]
    return "\n".join(lines)


def _directive(value):
    if inspect.isclass(value):
        return "autoexception" if issubclass(value, Exception) else "autoclass"
    return "autofunction" if callable(value) else None


def gallery():
    """Show every script in examples/: its pictures (docs/gallery/SCRIPT*.png), its docstring as
    their caption, all of it."""
    lines = [
        "# Gallery",
        "",
        "The scripts of `examples/`, and what they draw. The tests run each on a small grid.",
        "",
    ]
    for script in sorted(EXAMPLES.glob("*.py")):
        source = script.read_text(encoding="utf-8")
        what, _, rest = ast.get_docstring(ast.parse(source)).partition("\n\n")
        what = " ".join(what.split())
        lines += [f"## {re.split('[:,.]', what)[0]}", ""]
        for picture in sorted(PICTURES.glob(f"{script.stem}*.png")):
            if picture.stem != script.stem and (EXAMPLES / f"{picture.stem}.py").exists():
                continue  # that of another script
            lines += [f"![{script.stem}](../gallery/{picture.name})", ""]
        lines += [f"*{what.replace('*', chr(92) + '*')}*", "", rest, ""]
        lines += [f"`examples/{script.name}`", "", "```python", source.strip(), "```", ""]
    return "\n".join(lines)
