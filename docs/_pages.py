"""Generate pages from the program: scene keys, observables, commands, Python API and the gallery of
examples/."""

import ast
import contextlib
import inspect
import io
import re
import shutil
from pathlib import Path

import hpc_gfmd
from hpc_gfmd.commands.cli import COMMANDS, main

HERE = Path(__file__).parent
EXAMPLES = HERE.parent / "examples"
PICTURES = HERE / "gallery"
MODULES = (  # (title, name, description) of public modules beside hpc_gfmd.__all__
    (
        "Reference curves",
        "hpc_gfmd.reference",
        (
            "Contact areas and mean gaps of self-affine surfaces, with uncertainties, from the runs"
            " of [the study](../study/README.md)."
        ),
    ),
    ("Persson's theory", "hpc_gfmd.theory.persson", "Needs only NumPy and SciPy, no solver."),
    ("Closed forms", "hpc_gfmd.theory.elastic", "Exact solutions with which the tests compare."),
    ("Adhesive contacts", "hpc_gfmd.theory.adhesion", "When a ball or a rough surface sticks."),
)


def pages():
    """Return all pages: {name: text}."""
    return {
        "scene": scene(),
        "observables": _printed("help", "observables", "--markdown"),
        "commands": commands(),
        "api": api(),
        "gallery": gallery(),
    }


def copy_notebooks(folder):
    """Copy the notebooks of examples/ into a folder; the site runs them."""
    for notebook in EXAMPLES.glob("*.ipynb"):
        shutil.copy2(notebook, folder)


def write(folder):
    """Write all pages to a folder; unchanged ones keep their date."""
    folder.mkdir(exist_ok=True)
    for name, text in pages().items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def scene():
    """Return the output of `hpc-gfmd help scene --markdown`."""
    return _printed("help", "scene", "--markdown")


def commands():
    """Return the output of `--help` of all commands as a page."""
    sections = [
        f"## hpc-gfmd {name}\n\n```text\n{_printed(name, '--help').strip()}\n```\n"
        for name in COMMANDS
    ]
    about = "The output of `hpc-gfmd COMMAND --help`. `python -m hpc_gfmd` runs the same program."
    return f"# Commands\n\n{about}\n\n" + "\n".join(sections)


def _printed(*argv):
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.suppress(SystemExit):
        main(list(argv))
    assert out.getvalue(), f"hpc-gfmd {' '.join(argv)} printed nothing"
    return out.getvalue()


def api():
    """Return the page of everything in hpc_gfmd.__all__ and of the modules in MODULES."""
    objects = {name: getattr(hpc_gfmd, name) for name in hpc_gfmd.__all__}
    groups = {"Functions": "autofunction", "Results": "autoclass", "Errors": "autoexception"}
    lines = ["# Python", "", "`import hpc_gfmd` neither starts MPI nor compiles anything.", ""]
    for title, directive in groups.items():
        names = [name for name, value in objects.items() if _directive(value) == directive]
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
    """Return the page of all scripts in examples/ with their pictures (docs/gallery/SCRIPT*.png).

    The first paragraph of a script's docstring is the caption; thumbnails lead to the scripts.
    """
    thumbnails = []
    sections = []
    for script in sorted(EXAMPLES.glob("*.py")):
        source = script.read_text(encoding="utf-8")
        summary, _, rest = ast.get_docstring(ast.parse(source)).partition("\n\n")
        summary = " ".join(summary.split())
        title = re.split("[:,.]", summary)[0]
        picture = f"![{title}](../gallery/{script.stem}.png)"
        thumbnails += [f"[{picture} {title}](#example-{script.stem})", ""]
        sections += [f"(example-{script.stem})=", f"## {title}", ""]
        for picture in sorted(PICTURES.glob(f"{script.stem}*.png")):
            if picture.stem != script.stem and (EXAMPLES / f"{picture.stem}.py").exists():
                continue  # that of another script
            sections += [f"![{script.stem}](../gallery/{picture.name})", ""]
        sections += [f"*{summary.replace('*', chr(92) + '*')}*", "", rest, ""]
        sections += [f"`examples/{script.name}`", "", "```python", source.strip(), "```", ""]
    head = [
        "# Gallery",
        "",
        "The scripts of `examples/` and their pictures. The tests run each on a small grid.",
        "Three notebooks show a whole task each: [from a scan to a seal](seal.ipynb),",
        "[a seal that relaxes](relaxing_seal.ipynb),",
        "[from two scans to a heat sink](heat_sink.ipynb).",
        "",
        "::::{container} thumbnails",
    ]
    return "\n".join([*head, *thumbnails, "::::", "", *sections])
