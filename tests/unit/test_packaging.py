"""Published files are consistent: one version, working links, a complete source archive."""

import configparser
import json
import re
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

import pytest

import hpc_gfmd

ROOT = Path(__file__).parents[2]
LINK = re.compile(r"!?\[[^\]]*\]\((?!https?:|#)([^)#]+)")
RELEASED = {
    "CITATION.cff": r"^version: (.+)$",
    "codemeta.json": r'^  "version": "(.+)",$',
    "CHANGELOG.md": r"^## \[(\d[^\]]*)\]",
}


def text(path):
    return (ROOT / path).read_text(encoding="utf-8")


def test_one_version():
    """Published files name the last release; code after it has a development version."""
    releases = {re.search(rule, text(path), re.MULTILINE)[1] for path, rule in RELEASED.items()}
    (release,) = releases
    is_changed = re.search(r"^## \[Unreleased\]\s+(?!## )\S", text("CHANGELOG.md"), re.MULTILINE)
    if is_changed:
        assert re.fullmatch(r"\d+\.\d+\.\d+\.dev\d+", hpc_gfmd.__version__)
    else:
        assert hpc_gfmd.__version__ == release


def test_one_description():
    """codemeta.json agrees with the metadata and CITATION.cff."""
    codemeta = json.loads(text("codemeta.json"))
    config = configparser.ConfigParser()
    config.read(ROOT / "setup.cfg", encoding="utf-8")
    metadata = config["metadata"]
    options = config["options"]
    citation = text("CITATION.cff")
    assert codemeta["name"] == tomllib.loads(text("pyproject.toml"))["project"]["name"]
    assert codemeta["description"] == metadata["description"]
    assert codemeta["license"].endswith(metadata["license_expression"])
    assert codemeta["author"][0]["name"] == metadata["author"]
    assert f'date-released: "{codemeta["datePublished"]}"' in citation
    assert codemeta["referencePublication"]["name"] in citation
    required = re.findall(r"^[\w-]+", options["install_requires"], re.MULTILINE)
    assert {package["name"] for package in codemeta["softwareRequirements"]} <= set(required)


@pytest.mark.parametrize("path", ["README.md", "CHANGELOG.md", "CONTRIBUTING.md"])
def test_links_to_files_work(path):
    links = LINK.findall(text(path))
    assert links
    assert [link for link in links if not (ROOT / link).exists()] == []


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """Files of the built source archive: {path in the repository: content}."""
    folder = tmp_path_factory.mktemp("dist")
    build = f"from setuptools import build_meta; build_meta.build_sdist({str(folder)!r})"
    subprocess.run([sys.executable, "-c", build], cwd=ROOT, check=True, capture_output=True)
    (path,) = folder.iterdir()
    assert path.name == f"hpc_gfmd-{hpc_gfmd.__version__}.tar.gz"
    with tarfile.open(path) as file:
        return {
            member.name.partition("/")[2]: file.extractfile(member).read()
            for member in file
            if member.isfile()
        }


def test_source_archive_contains_the_repository(archive):
    """All files of git but hidden ones, and no generated files."""
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.split("\n")[:-1]
    wanted = {name for name in listed if not name.startswith(".")} or {
        "tests/conftest.py",
        "scripts/setup",
        "docs/conf.py",
    }
    assert wanted <= set(archive)
    assert not [name for name in archive if re.search(r"__pycache__|\.h5$|\.venv|generated/", name)]
