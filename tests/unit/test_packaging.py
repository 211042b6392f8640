"""What is published agrees with itself: one version, links that lead somewhere, an archive with all that the tests need."""

import re
from pathlib import Path

import pytest

import hpc_gfmd

ROOT = Path(__file__).parents[2]
LINK = re.compile(r"!?\[[^\]]*\]\((?!https?:|#)([^)#]+)")
VERSIONED = {
    "CITATION.cff": r"^version: (.+)$",
    "CHANGELOG.md": r"^## \[(\d[^\]]*)\]",
    "packaging/conda/recipe.yaml": r'^  version: "(.+)"$',
    "packaging/spack/packages/py_hpc_gfmd/package.py": r'^    version\("([^"]+)"',
    "packaging/apptainer/hpc-gfmd.def": r"hpc_gfmd-(.+)\.tar\.gz /opt$",
}


def text(path):
    return (ROOT / path).read_text(encoding="utf-8")


@pytest.mark.parametrize("path", VERSIONED)
def test_one_version(path):
    assert re.search(VERSIONED[path], text(path), re.MULTILINE)[1] == hpc_gfmd.__version__


@pytest.mark.parametrize("path", ["README.md", "CHANGELOG.md", "CONTRIBUTING.md"])
def test_links_lead_somewhere(path):
    links = LINK.findall(text(path))
    assert links
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_links_of_the_published_readme_are_absolute(monkeypatch):
    """Run setup.py as a build does and take what it hands over."""
    given = {}
    monkeypatch.setattr("setuptools.setup", given.update)
    exec(compile(text("setup.py"), ROOT / "setup.py", "exec"), {"__file__": str(ROOT / "setup.py")})
    assert LINK.findall(text("README.md"))
    assert LINK.findall(given["long_description"]) == []
    address = re.search(r"^url = (\S+)$", text("setup.cfg"), re.MULTILINE)[1]
    assert f"]({address}/blob/v{hpc_gfmd.__version__}/docs/" in given["long_description"]
    assert f"]({address}/raw/v{hpc_gfmd.__version__}/docs/contact.png)" in given["long_description"]


def test_every_folder_is_in_the_source_archive():
    grafted = set(re.findall(r"^graft (\S+)", text("MANIFEST.in"), re.MULTILINE))
    folders = {path.parent.name for pattern in ("*/*.py", "*/README.md", "*/setup", "*/conf.py") for path in ROOT.glob(pattern)}
    folders = {name for name in folders if not name.startswith(".")}
    assert {"docs", "scripts", "slurm", "tests", "packaging"} <= grafted
    assert folders - grafted <= {"hpc_gfmd", "build", "dist"}
