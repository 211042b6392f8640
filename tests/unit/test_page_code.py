"""Code on the pages works: Python blocks, `hpc-gfmd` commands and scenes.

Quick tests read it. The slow test, which scripts/docs runs, runs it: output shown below a block
agrees with what it prints, numbers to the digits shown.
"""

import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from mpi_harness import environment

from hpc_gfmd.commands.cli import build_parser
from hpc_gfmd.scene import Scene

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
BLOCK = re.compile(
    r"^```([a-z]*)\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", re.MULTILINE | re.DOTALL
)
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")
COMMAND = re.compile(r"^hpc-gfmd (.*?)(?: *#.*)?$", re.MULTILINE)
WALL = {"kind": "file", "path": "scan.x3p"}
NEEDED = {"surface": WALL, "material": {"E_star": "2 GPa"}, "load": {"pressure": "1 MPa"}}


def blocks(page):
    """[(language, source, output shown below or "")] of a page."""
    return BLOCK.findall(page.read_text(encoding="utf-8"))


PAGES = [
    page
    for page in (ROOT / "README.md", *sorted(DOCS.glob("*.md")), *sorted(DOCS.glob("howto/*.md")))
    if page.stem != "developer"  # its code is in test_plugins.py
    and any(
        kind in ("python", "toml") or (kind == "" and COMMAND.search(source))
        for kind, source, _ in blocks(page)
    )
]


SCAN = blocks(DOCS / "tutorial.md")[-1][1]  # the script at its end makes scan.x3p
(SCENE,) = (source for kind, source, _ in blocks(ROOT / "README.md") if kind == "toml")


def agree(shown, printed):
    """Whether words are equal and numbers agree within one unit of the last digit shown.

    `...` stands for any text.
    """
    words = NUMBER.split(shown)
    gaps = [r"\s+".join(map(re.escape, re.split(r"\s+", part))) for part in words]
    pattern = r"\s*([-+]?[\d.]+(?:e[-+]?\d+)?)\s*".join(gaps).replace(r"\.\.\.", ".*?")
    match = re.search(pattern, printed, re.DOTALL)
    return match is not None and all(
        abs(float(x) - float(y)) <= 1.001 * last_digit(x)
        for x, y in zip(NUMBER.findall(shown), match.groups(), strict=True)
    )


def last_digit(number):
    """The value of the last digit: 0.01 for 3.14, 100 for 1.5e3."""
    digits, _, power = number.partition("e")
    return 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))


@pytest.mark.parametrize(
    ("shown", "printed", "agrees"),
    [
        ("a_r = 3.14 %", "x\na_r = 3.138 %\n", True),
        ("a_r = 3.14 %", "a_r = 3.16 %", False),
        ("[0.1 2e-3]", "[0.098   0.0021]", True),
        ("p 5 ... s", "p 5 other\nthings s", True),
        ("converged", "stagnated", False),
        ("2 MPa", "3 MPa", True),
        ("2 MPa", "4 MPa", False),
    ],
)
def test_agree(shown, printed, agrees):
    assert agree(shown, printed) is agrees


def run(folder, *arguments):
    """The output and errors of `python arguments`, which has to succeed."""
    completed = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=environment(MPLBACKEND="Agg", COLUMNS="100", HPC_GFMD_PROGRESS="log"),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert completed.returncode == 0, completed.stdout
    return completed.stdout


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """The path of scan.x3p, made by the script at the end of the tutorial."""
    folder = tmp_path_factory.mktemp("scan")
    (folder / "scan.py").write_text(SCAN)
    run(folder, "scan.py")
    return folder / "scan.x3p"


def scene_of(source):
    """The scene of a block of TOML, completed where a page shows a part of it."""
    scene = NEEDED | tomllib.loads(source)
    if scene["surface"].get("kind", "file") == "file" and "bodies" not in scene["surface"]:
        scene["surface"] = WALL | scene["surface"]
    return scene


def commands_of(source):
    """The words of every `hpc-gfmd` command of a block."""
    for line in COMMAND.findall(source.replace("\\\n", " ")):
        yield shlex.split(line.partition(" > ")[0])


def test_code_of_all_pages_is_read():
    """Python compiles, scenes are valid, commands and their options exist."""
    for page in PAGES:
        for kind, source, _ in blocks(page):
            if kind == "python":
                compile(source, str(page), "exec")
            elif kind == "toml":
                Scene.from_dict(scene_of(source))
            elif kind == "":
                for words in commands_of(source):
                    build_parser().parse_args(words)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_code_of_a_page(page, scan, tmp_path):
    """Python blocks share one process, and commands run one after another."""
    shutil.copy(scan, tmp_path)
    if page.stem != "tutorial":  # it makes the scene
        (tmp_path / "scene.toml").write_text(SCENE)
    program = []
    wanted = []
    for kind, source, shown in blocks(page):
        if kind == "python":
            program.append(source + f"\nprint('block {len(wanted)}')\n")
            wanted.append(shown)
        elif kind == "":
            for words in commands_of(source):
                printed = run(tmp_path, "-m", "hpc_gfmd", *words)
            assert not shown or agree(shown.strip(), printed)
    if program:
        (tmp_path / "page.py").write_text("".join(program))
        printed = run(tmp_path, "page.py")
        for k, shown in enumerate(wanted):
            part, _, printed = printed.partition(f"block {k}\n")
            assert not shown or agree(shown.strip(), part), part
