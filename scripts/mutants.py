"""Change the core in one place at a time, and count how many changes the quick tests notice.

python scripts/mutants.py --count 150 --jobs 2 --out mutants.jsonl

A mutant has one other sign, comparison or factor. The tests run on a copy of the repository, until
the first one fails. Of a survivor either no test can tell (the mutant is equivalent), or a test is
missing. Where the tests take far more processor time than without a mutant it is unknown: look
whether a loop does not end.
"""

import argparse
import ast
import copy
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[1]
CORE = ("driver", "solvers", "certificate", "operators", "bodies", "laws", "kernels")
TESTS = ("tests/contract", "tests/physics", "tests/campaign")  # after those of the folder
TIMEOUT = "timeout"
OUTCOMES = {"": "SURVIVED", TIMEOUT: "UNKNOWN"}  # of all others: killed
SECONDS = 600  # of processor time for a process of the tests of a mutant
OTHERS = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.And: ast.Or,
    ast.Or: ast.And,
}


def sites(tree):
    """Yield (node, its replacement) for all places that can change."""
    for node in ast.walk(tree):
        other = copy.deepcopy(node)
        if (
            isinstance(node, ast.BinOp) and type(node.op) in OTHERS and not _is_text(node)
        ) or isinstance(node, ast.BoolOp):
            other.op = OTHERS[type(node.op)]()
        elif isinstance(node, ast.Compare) and type(node.ops[0]) in OTHERS:
            other.ops[0] = OTHERS[type(node.ops[0])]()
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            other = other.operand
        elif isinstance(node, ast.Constant) and type(node.value) is float and node.value:
            other.value = 2 * node.value
        else:
            continue
        yield node, other


def _is_text(node):
    """Whether an operation joins texts."""
    return any(
        isinstance(part, ast.JoinedStr)
        or (isinstance(part, ast.Constant) and isinstance(part.value, str))
        for part in (node.left, node.right)
    )


def changed(source, node, other):
    """Return a source with one expression replaced."""
    lines = source.encode().splitlines(keepends=True)
    start = sum(map(len, lines[: node.lineno - 1])) + node.col_offset
    end = sum(map(len, lines[: node.end_lineno - 1])) + node.end_col_offset
    data = source.encode()
    return (data[:start] + f"({ast.unparse(other)})".encode() + data[end:]).decode()


def draw(count, seed, folders=CORE):
    """Return (path, line, before, after, source) of some mutants, drawn from all places."""
    every = []
    for path in sorted(p for folder in folders for p in (ROOT / "hpc_gfmd" / folder).rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        places = [(path, source, *site) for site in sites(ast.parse(source))]
        every += sorted(places, key=lambda place: (place[2].lineno, place[2].col_offset))
    mutants = []
    for path, source, node, other in random.Random(seed).sample(every, min(count, len(every))):
        before, after = ast.unparse(node), ast.unparse(other)
        name = path.relative_to(ROOT).as_posix()
        mutants.append((name, node.lineno, before, after, changed(source, node, other)))
    return mutants


def copied():
    """Return a copy of what the tests read, in a new folder."""
    folder = Path(tempfile.mkdtemp(prefix="hpc-gfmd-mutants-"))
    names = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    for name in filter(lambda name: (ROOT / name).is_file(), names):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    return folder


def tests_fail(folder, part, kernels):
    """Return the first test of a copy that fails, TIMEOUT, or "" where all pass."""
    unit = f"tests/unit/{part}"
    paths = [*([unit] if (folder / unit).is_dir() else []), *TESTS]
    tests = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-p", "no:xdist"]
        + ["--tb=no", "-m", "not mpi and not slow", *paths],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(kernels)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS)),
    )
    if tests.returncode == -signal.SIGKILL:
        return TIMEOUT
    if tests.returncode == 0:
        return ""
    failed = [x for x in tests.stdout.splitlines() if x.startswith(("FAILED", "ERROR"))]
    return failed[0][:200] if failed else tests.stdout[-200:]


def tried(mutant, folders, kernels):
    """Run the tests on a mutant; return a row of the report."""
    path, line, before, after, source = mutant
    folder = folders.pop()
    part = Path(path).parts[1]
    begun = time.monotonic()
    own_kernels = Path(tempfile.mkdtemp(dir=folder)) if part == "kernels" else kernels
    original = (folder / path).read_text(encoding="utf-8")
    (folder / path).write_text(source, encoding="utf-8")
    try:
        killer = tests_fail(folder, part, own_kernels)
    finally:
        (folder / path).write_text(original, encoding="utf-8")
        folders.append(folder)
        if own_kernels != kernels:
            shutil.rmtree(own_kernels, ignore_errors=True)
    row = {"path": path, "line": line, "before": before, "after": after, "killer": killer}
    return row | {"seconds": round(time.monotonic() - begun)}


def main():
    """Print one line for each mutant and the score."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=150)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--folders", nargs="+", default=CORE)
    parser.add_argument("--out", help="append a line of JSON for each mutant")
    args = parser.parse_args()
    folders = [copied() for _ in range(args.jobs)]
    kernels = folders[0] / "kernels-cache"
    if failed := tests_fail(folders[0], "none", kernels):
        sys.exit(f"the tests fail without any mutant: {failed}")
    rows = []
    with ThreadPoolExecutor(args.jobs) as pool:
        mutants = draw(args.count, args.seed, args.folders)
        for row in pool.map(lambda mutant: tried(mutant, folders, kernels), mutants):
            rows.append(row)
            outcome = OUTCOMES.get(row["killer"], "killed")
            change = "{path}:{line}: {before} -> {after}".format(**row)
            print(f"{outcome:8} {change} ({row['seconds']} s) {row['killer']}")
            sys.stdout.flush()
            if args.out:
                with open(args.out, "a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
    counts = Counter(OUTCOMES.get(row["killer"], "killed") for row in rows)
    print(f"{len(rows)} mutants: " + ", ".join(f"{n} {name}" for name, n in counts.items()))
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
