"""How the wheel and the source archive are made (PEP 517, named in pyproject.toml): setuptools,
with two things of our own.

README.md has links relative to the repository, which lead nowhere on other pages: what is published
has their words alone. The source archive has all of the repository, tests included.
"""

import re
import tarfile
import tempfile
from pathlib import Path

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403 - the other hooks

PUBLISHED = Path("build/README.md")  # `long_description` in setup.cfg
ARCHIVED = (
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "LICENSE",
    "README.md",
    "SECURITY.md",
    "codemeta.json",
    "pyproject.toml",
    "setup.cfg",
    "docs",
    "examples",
    "hpc_gfmd",
    "packaging",
    "scripts",
    "slurm",
    "tests",
)
LEFT_OUT = re.compile(
    r"/(__pycache__|\.hypothesis|\.ruff_cache)$|\.(pyc|h5)$|docs/(_build|generated)$"
)


def version():
    """The project's version."""
    source = Path("hpc_gfmd/__init__.py").read_text(encoding="utf-8")
    return re.search(r'^__version__ = "(.+)"', source, re.MULTILINE)[1]


def without_links(text):
    """Markdown without pictures and links that lead into the repository: their words stay."""
    text = re.sub(r"!\[[^\]]*\]\((?!https?:)[^)]+\)\n*", "", text)
    return re.sub(r"\[([^\]]*)\]\((?!https?:|#)[^)]+\)", r"\1", text)


def build_sdist(sdist_directory, config_settings=None):
    """The archive of ARCHIVED with the metadata as PKG-INFO; returns its name."""
    name = f"hpc_gfmd-{version()}"
    with (
        tempfile.TemporaryDirectory() as folder,
        tarfile.open(Path(sdist_directory) / f"{name}.tar.gz", "w:gz") as archive,
    ):
        info = (
            Path(folder)
            / build_meta.prepare_metadata_for_build_wheel(folder, config_settings)
            / "METADATA"
        )
        archive.add(info, f"{name}/PKG-INFO")
        for entry in ARCHIVED:
            archive.add(
                entry,
                f"{name}/{entry}",
                filter=lambda member: None if LEFT_OUT.search(member.name) else member,
            )
    return f"{name}.tar.gz"


PUBLISHED.parent.mkdir(exist_ok=True)
PUBLISHED.write_text(without_links(Path("README.md").read_text(encoding="utf-8")), encoding="utf-8")
