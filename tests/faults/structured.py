"""Result files that are valid HDF5 with any content."""

import h5py
import numpy as np
from faults.readers import outcome
from faults.seeds import FIELD, SCENE, STEP, SURFACE
from hypothesis import strategies as st

from hpc_gfmd.output.read import FORMAT
from hpc_gfmd.output.record import set_attributes
from hpc_gfmd.output.result import FORMAT_VERSION

ODD = [
    *(np.complex128(1j), h5py.Empty("f8"), np.zeros((2, 2)), np.bytes_(b"\xff\xfe")),
    *(np.zeros(3, "i1"), np.array([(1, 2.0)], dtype="i4,f8"), 10**18, "\x1b[2J", "line\nline"),
]
VALUES = st.one_of(
    st.integers(-(2**63), 2**63 - 1) | st.floats() | st.booleans(),
    st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=10),
    st.lists(st.floats() | st.just(1.0), max_size=4),
    st.lists(st.integers(-9, 9), max_size=3),
    st.sampled_from(ODD),
)
MORE = """note precision kappa fft_pairs wall_seconds pressure_error format_version versions scene
    more"""
ATTRIBUTES = st.dictionaries(st.sampled_from([*STEP, *SURFACE, *MORE.split()]), VALUES, max_size=4)
SIMPLE = {
    "field": FIELD,
    "integers": FIELD.astype(int),
    "complex": FIELD + 1j,
    "other shape": FIELD.T,
    "cube": FIELD[None],
    "scalar": 3.0,
    "text": np.full(FIELD.shape, b"abc"),
    "wide": FIELD.astype("g"),
    "external link": h5py.ExternalLink("elsewhere.h5", "/surface"),
    "soft link": h5py.SoftLink("/real"),
    "dangling": h5py.SoftLink("/nowhere/at/all"),
    "circle": h5py.SoftLink("/steps/0000/gap"),
}
MADE = {
    "objects": {"shape": FIELD.shape, "dtype": h5py.string_dtype()},
    "huge": {"shape": (2**40, 2**22), "dtype": "f8", "chunks": (1024, 1024)},
    "external": {"shape": FIELD.shape, "dtype": "f8", "external": [("elsewhere.h5", 0, 240)]},
}
results = st.fixed_dictionaries(
    {
        "head": ATTRIBUTES,
        "surface": ATTRIBUTES,
        "step": ATTRIBUTES,
        "fields": st.dictionaries(
            st.sampled_from(["gap", "pressure", "x"]),
            st.sampled_from([*SIMPLE, *MADE, "group", "virtual"]),
            max_size=2,
        ),
        "left_out": st.sampled_from(["", "surface", "steps", "step"]),
    }
)


def put(group, name, kind):
    """Make a dataset or link of some kind, perhaps to elsewhere.h5, which no reader may open."""
    if kind in SIMPLE:
        group[name] = SIMPLE[kind]
    elif kind in MADE:
        group.create_dataset(name, **MADE[kind])
    elif kind == "group":
        group.create_group(name)
    else:
        layout = h5py.VirtualLayout(FIELD.shape, "f8")
        layout[:] = h5py.VirtualSource("elsewhere.h5", "surface", FIELD.shape)
        group.create_virtual_dataset(name, layout)


def write_result(path, content):
    """Write a result file with content from `results`: changed attributes, fields of any kind."""
    head = {"format": FORMAT, "format_version": FORMAT_VERSION, "scene": SCENE.read_text()}
    with h5py.File(path, "w") as file:
        file["real"] = FIELD
        _set(file, head | {"status": "converged"}, content["head"])
        if content["left_out"] != "surface":
            _set(file.create_group("surface"), SURFACE, content["surface"])
        if content["left_out"] != "steps":
            steps = file.create_group("steps")
            if content["left_out"] != "step":
                step = steps.create_group("0000")
                _set(step, STEP, content["step"])
                for name, kind in content["fields"].items():
                    put(step, name, kind)


def check_result(content):
    """Write a result file with some content to the current folder and read it."""
    with h5py.File("elsewhere.h5", "w") as file:
        file["surface"] = FIELD
    write_result("any.h5", content)
    result = outcome("result", "any.h5")
    kinds = set(content["fields"].values())
    bad = kinds & {"external", "virtual", "external link", "complex", "text"}
    if bad and not content["left_out"]:
        assert result == "refused", kinds


def _set(group, attributes, changes):
    set_attributes(group, {".": attributes})
    for name, value in changes.items():
        group.attrs[name] = value
