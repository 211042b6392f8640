"""Coverage-guided fuzzing of one reader: `python tests/fuzz/run.py TARGET -max_total_time=300`, with atheris installed.

Targets are those of readers.py, and "tables" and "contents": scenes and result files whose parts hypothesis makes. Further arguments
go to libFuzzer. Inputs that break something are kept in tests/fuzz/regressions/TARGET, where test_readers.py replays them; what was
tried is added to docs/faults/fuzzing.jsonl, of which docs/faults/fuzzing.md is made.
"""

import hashlib
import json
import random
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from datetime import UTC, datetime
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS), str(TESTS / "unit"), str(TESTS.parent)]
RECORDS = TESTS.parent / "docs" / "faults" / "fuzzing.jsonl"
MADE = ("tables", "contents")  # by hypothesis out of bytes
LARGEST = 20_000  # bytes of an input that is kept
COUNT_EVERY = 100
PATIENCE = 180  # seconds that a fuzzer may take to start and to end


def child(target, folder, arguments):
    """The process that fuzzes: counts outcomes in `folder` until libFuzzer ends it."""
    import atheris

    with atheris.instrument_imports(include=["hpc_gfmd", "tomllib", "scipy.io._netcdf", "numpy.lib.format"]):
        from fuzz import readers

    counts = {"read": 0, "refused": 0, "nothing": 0, "crashed": 0}
    try_one = _made(target, folder) if target in MADE else _bytes(target, folder, readers)

    def test(data):
        counts[try_one(data)] += 1  # whatever else comes back is an error
        if sum(counts.values()) % COUNT_EVERY == 0:
            (folder / "counts.json").write_text(json.dumps(counts))

    atheris.Setup([sys.argv[0], *arguments], test)
    atheris.Fuzz()


def _bytes(target, folder, readers):
    path = folder / f"any{readers.READERS[target][1]}"

    def try_one(data):
        path.write_bytes(data)
        return (readers.outcome_apart if target in readers.HDF5 else readers.outcome)(target, path)

    return try_one


def _made(target, folder):
    from fuzz.structured import check_result, results
    from hypothesis import HealthCheck, given, settings
    from test_scene_properties import ANYTHING

    from hpc_gfmd.errors import SceneError
    from hpc_gfmd.scene import Scene

    def tables(data):
        try:
            scene = Scene.from_dict(data)
        except SceneError as error:
            return "refused" if str(error).isprintable() else str(error)
        assert Scene.from_toml(scene.to_toml()) == scene
        return "read"

    strategy, check = (ANYTHING, tables) if target == "tables" else (results, lambda content: check_result(content, folder))
    found = []

    @settings(database=None, deadline=None, suppress_health_check=list(HealthCheck))
    @given(strategy)
    def property_(value):
        found.append(check(value))

    def try_one(data):
        found.clear()
        property_.hypothesis.fuzz_one_input(data)
        return found[-1] if found else "nothing"  # bytes of which hypothesis makes no value

    return try_one


def main(target, arguments):
    """Fuzz, keep what broke, and say how much was tried; the exit code is that of libFuzzer."""
    from fuzz.readers import READERS
    from fuzz.seeds import seeds

    if target not in (*READERS, *MADE):
        raise SystemExit(f"target: found {target}, allowed: {', '.join((*READERS, *MADE))}")
    with tempfile.TemporaryDirectory(prefix="hpc-gfmd-fuzz-") as folder:
        folder = Path(folder)
        corpus, kept = folder / "corpus", TESTS / "fuzz" / "regressions" / target
        corpus.mkdir()
        (folder / "seeds").mkdir()
        for path in [*(seeds(target, folder / "seeds") if target in READERS else []), *kept.glob("*")]:
            shutil.copy(path, corpus / f"{path.parent.name}-{path.name}")
        if target in MADE:
            arguments = ["-len_control=0", "-max_len=4096", *arguments]
            for seed in range(50):
                (corpus / str(seed)).write_bytes(random.Random(seed).randbytes(2000))
        begun = time.monotonic()
        command = [sys.executable, __file__, "--child", target, str(folder), str(corpus), f"-artifact_prefix={folder}/broke-",
                   "-print_final_stats=1", "-timeout=30", "-report_slow_units=30", "-rss_limit_mb=4096", *arguments]
        seconds = next((int(a.split("=")[1]) for a in arguments if a.startswith("-max_total_time=")), 10**9)
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, errors="replace") as process:
            watchdog = threading.Timer(min(seconds + PATIENCE, threading.TIMEOUT_MAX), process.kill)
            watchdog.start()
            lines = []
            for line in process.stderr:
                lines.append(line)
                print(line, end="", file=sys.stderr)
            watchdog.cancel()
        found = sorted(folder.glob("broke-*")) or (sorted(folder.glob("any.*")) if process.wait() < 0 else [])
        for path in found:
            kept.mkdir(parents=True, exist_ok=True)
            if path.stat().st_size <= LARGEST:
                shutil.copy(path, kept / hashlib.sha256(path.read_bytes()).hexdigest()[:12])
        counts = json.loads((folder / "counts.json").read_text()) if (folder / "counts.json").exists() else {}
    _record(target, "".join(lines), counts, len(found), time.monotonic() - begun)
    return process.returncode


def _record(target, output, counts, broken, seconds):
    import importlib.metadata

    executed = re.search(r"number_of_executed_units: (\d+)", output)
    line = {"target": target, "fuzzer": f"atheris {importlib.metadata.version('atheris')}",
            "inputs": int(executed.group(1)) if executed else sum(counts.values()), "read": counts.get("read", 0),
            "refused": counts.get("refused", 0), "broken": broken, "seconds": round(seconds),
            "time": datetime.now(UTC).isoformat(timespec="seconds")}
    RECORDS.parent.mkdir(parents=True, exist_ok=True)
    with RECORDS.open("a") as file:
        file.write(json.dumps(line) + "\n")
    RECORDS.with_suffix(".md").write_text(page([json.loads(text) for text in RECORDS.read_text().splitlines()]))
    print(f"{target}: {line['inputs']} inputs in {seconds:.0f} s, {broken} broke something")


def page(lines):
    """The page about fuzzing as Markdown."""
    rows = []
    for target in dict.fromkeys(line["target"] for line in lines):
        own = [line for line in lines if line["target"] == target]
        total = {key: sum(line[key] for line in own) for key in ("inputs", "seconds", "broken", "read", "refused")}
        share = total["read"] / max(total["read"] + total["refused"], 1)
        kept = len(list((TESTS / "fuzz" / "regressions" / target).glob("*")))
        rows.append(f"| {target} | {total['inputs']:,} | {total['seconds']} | {100 * share:.3g} % | {total['broken']} | {kept} |\n")
    return HEAD.format(inputs=sum(line["inputs"] for line in lines), fuzzers=", ".join(sorted({line["fuzzer"] for line in lines})),
                       seconds=sum(line["seconds"] for line in lines)) + "".join(rows)


HEAD = """# Fuzzing

{inputs:,} inputs in {seconds} s by {fuzzers}, counted by the runner, `python tests/fuzz/run.py TARGET -max_total_time=300`, which
writes this page. Allowed is that a file is read, or refused by one printable line; a traceback, a crash, more than 30 s or 4 GiB
count as broken. "Found" are runs that ended with such an input (all runs so far, those before the repair included), "kept" the inputs
that `tests/fuzz/test_readers.py` replays. That test also makes a few hundred inputs of its own in every quick test run.

The targets are the readers: scene files; height maps from .npy, HDF5 and NetCDF; result files; checkpoints; tables of runs (CSV) and of
coefficients (JSON). "tables" and "contents" are scenes and valid HDF5 files whose parts are anything that TOML and HDF5 can say: other
types, shapes, links to other files, virtual and external datasets. The HDF5 library itself is no part of what is tested: files
that make it crash count neither as read nor as broken.

| target | inputs | seconds | read | found | kept |
|---|---|---|---|---|---|
"""

if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        child(sys.argv[2], Path(sys.argv[3]), sys.argv[4:])
    elif len(sys.argv) > 1:
        sys.exit(main(sys.argv[1], sys.argv[2:]))
    else:
        raise SystemExit(__doc__)
