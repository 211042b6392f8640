"""How the wheel and the source archive are made (PEP 517, named in pyproject.toml): setuptools,
with two things of our own.

README.md has links relative to the repository, which lead nowhere on other pages: what is published
has them absolute. The source archive has all of the repository, tests included.
"""

import re
import tarfile
import tempfile
from configparser import ConfigParser
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


def metadata():
    """(address of the project, version)."""
    config = ConfigParser()
    config.read("setup.cfg", encoding="utf-8")
    source = Path("hpc_gfmd/__init__.py").read_text(encoding="utf-8")
    return config["metadata"]["url"], re.search(r'^__version__ = "(.+)"', source, re.MULTILINE)[1]


def absolute(text):
    """Markdown whose links and pictures lead to the release's tag, as forges serve it."""
    url, version = metadata()
    return re.sub(
        r"(!?)\[([^\]]*)\]\((?!https?:|#)([^)]+)\)",
        lambda link: (
            f"{link[1]}[{link[2]}]({url}/{'raw' if link[1] else 'blob'}/v{version}/{link[3]})"
        ),
        text,
    )


def build_sdist(sdist_directory, config_settings=None):
    """The archive of ARCHIVED with the metadata as PKG-INFO; returns its name."""
    name = f"hpc_gfmd-{metadata()[1]}"
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
PUBLISHED.write_text(absolute(Path("README.md").read_text(encoding="utf-8")), encoding="utf-8")
