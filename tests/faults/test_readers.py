"""Any file is read or refused in one line: changed bytes, and files that once caused errors."""

import hashlib
from pathlib import Path

import pytest
from faults.readers import READERS, outcome, outcome_apart
from faults.seeds import seeds
from hypothesis import given, settings
from hypothesis import strategies as st

REGRESSIONS = sorted(p for p in (Path(__file__).parent / "regressions").glob("*/*") if p.is_file())
# Numbers of changed files. Other targets, which are all HDF5, are read in a child process each.
EXAMPLES = {"scene": 150, "npy": 100, "coefficients": 60}
EDITS = st.lists(
    st.tuples(
        st.sampled_from(["set", "cut", "insert", "copy"]),
        st.floats(0, 1),
        st.binary(min_size=1, max_size=8),
    ),
    min_size=1,
    max_size=6,
)


def changed(data, edits):
    """Return data with some bytes set, cut out, inserted or repeated elsewhere."""
    data = bytearray(data)
    for kind, where, new in edits:
        place = int(where * len(data))
        if kind == "set":
            data[place : place + len(new)] = new
        elif kind == "cut":
            del data[place : place + 8 * new[0]]
        elif kind == "insert":
            data[place:place] = new
        else:
            data[place:place] = data[: new[0]]
    return bytes(data)


@pytest.mark.parametrize("target", READERS)
def test_changed_bytes(target, tmp_path):
    originals = [path.read_bytes() for path in seeds(target, tmp_path)]
    path = tmp_path / f"any{READERS[target][1]}"

    @settings(max_examples=EXAMPLES.get(target, 40))
    @given(st.sampled_from(originals), EDITS)
    def check(data, edits):
        path.write_bytes(changed(data, edits))
        before = sorted(tmp_path.iterdir())
        (outcome if target in EXAMPLES else outcome_apart)(target, path)
        assert sorted(tmp_path.iterdir()) == before

    check()


@pytest.mark.parametrize("target", READERS)
def test_the_seeds_are_read(target, tmp_path):
    """They are read without any change, even of their times."""
    outcomes = []
    for path in seeds(target, tmp_path):
        before = hashlib.sha256(path.read_bytes()).digest(), path.stat().st_mtime_ns
        outcomes.append(outcome(target, path))
        assert (hashlib.sha256(path.read_bytes()).digest(), path.stat().st_mtime_ns) == before
    assert outcomes[0] == "read"


@pytest.mark.parametrize("path", REGRESSIONS, ids=lambda p: f"{p.parent.name}-{p.name}")
def test_regressions(path, tmp_path):
    target = path.parent.name
    copy = tmp_path / f"any{READERS[target][1]}"
    copy.write_bytes(path.read_bytes())
    outcome_apart(target, copy)
