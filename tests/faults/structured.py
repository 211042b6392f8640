"""Result files, height maps and links in them that are valid HDF5 and otherwise anything."""

import h5py
import numpy as np
from faults.readers import outcome
from faults.seeds import FIELD, SCENE, STEP, SURFACE
from hypothesis import strategies as st

from hpc_gfmd.output.read import FORMAT, FORMAT_VERSION
from hpc_gfmd.output.record import set_attributes

NUMBERS = st.integers(-(2**63), 2**63 - 1) | st.floats() | st.booleans()
VALUES = st.one_of(
    NUMBERS,
    st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=10),
    st.lists(st.floats() | st.just(1.0), max_size=4),
    st.lists(st.integers(-9, 9), max_size=3),
    st.sampled_from(
        [
            np.complex128(1j),
            h5py.Empty("f8"),
            np.zeros((2, 2)),
            np.bytes_(b"\xff\xfe"),
            np.zeros(3, "i1"),
            np.array([(1, 2.0)], dtype="i4,f8"),
            10**18,
            "\x1b[2J",
            "line\nline",
        ]
    ),
)
NAMES = st.sampled_from(
    [
        *STEP,
        *SURFACE,
        "note",
        "precision",
        "kappa",
        "fft_pairs",
        "wall_seconds",
        "pressure_error",
        "format_version",
        "versions",
        "scene",
        "more",
    ]
)
ATTRIBUTES = st.dictionaries(NAMES, VALUES, max_size=4)
DATASETS = st.sampled_from(
    [
        "field",
        "integers",
        "complex",
        "text",
        "objects",
        "other shape",
        "cube",
        "scalar",
        "external",
        "virtual",
        "external link",
        "soft link",
        "dangling",
        "circle",
        "group",
        "huge",
        "wide",
    ]
)
results = st.fixed_dictionaries(
    {
        "head": ATTRIBUTES,
        "surface": ATTRIBUTES,
        "step": ATTRIBUTES,
        "fields": st.dictionaries(st.sampled_from(["gap", "pressure", "x"]), DATASETS, max_size=2),
        "left_out": st.sampled_from(["", "surface", "steps", "step"]),
    }
)


def put(group, name, kind, elsewhere):
    """A dataset or link of some kind; elsewhere: a file that none may reach."""
    n = FIELD.shape
    simple = {
        "field": FIELD,
        "integers": FIELD.astype(int),
        "complex": FIELD + 1j,
        "other shape": FIELD.T,
        "cube": FIELD[None],
        "scalar": 3.0,
        "text": np.full(n, b"abc"),
        "wide": FIELD.astype("g"),
    }
    links = {
        "external link": h5py.ExternalLink(elsewhere, "/surface"),
        "soft link": h5py.SoftLink("/real"),
        "dangling": h5py.SoftLink("/nowhere/at/all"),
        "circle": h5py.SoftLink(f"{group.name}/{name}"),
    }
    if kind in simple:
        group[name] = simple[kind]
    elif kind in links:
        group[name] = links[kind]
    elif kind == "objects":
        group.create_dataset(name, n, dtype=h5py.string_dtype())
    elif kind == "group":
        group.create_group(name)
    elif kind == "huge":
        group.create_dataset(name, (2**40, 2**22), dtype="f8", chunks=(1024, 1024))
    elif kind == "external":
        group.create_dataset(
            name, n, dtype="f8", external=[(str(elsewhere), 0, h5py.h5f.UNLIMITED)]
        )
    elif kind == "virtual":
        layout = h5py.VirtualLayout(n, "f8")
        layout[:] = h5py.VirtualSource(str(elsewhere), "surface", n)
        group.create_virtual_dataset(name, layout)


def write_result(path, content, elsewhere):
    """A result file with the `content` that `results` gives: attributes changed after they were
    written, fields of any kind."""
    with h5py.File(path, "w") as file:
        file["real"] = FIELD
        _set(
            file,
            {
                "format": FORMAT,
                "format_version": FORMAT_VERSION,
                "scene": SCENE.read_text(),
                "status": "converged",
            },
            content["head"],
        )
        if content["left_out"] != "surface":
            _set(file.create_group("surface"), SURFACE, content["surface"])
        if content["left_out"] != "steps":
            steps = file.create_group("steps")
            if content["left_out"] != "step":
                step = steps.create_group("0000")
                _set(step, STEP, content["step"])
                for name, kind in content["fields"].items():
                    put(step, name, kind, elsewhere)


def check_result(content, folder):
    """Write it and read it."""
    path, elsewhere = folder / "any.h5", folder / "elsewhere.h5"
    if not elsewhere.exists():
        with h5py.File(elsewhere, "w") as file:
            file["surface"] = FIELD
    write_result(path, content, elsewhere)
    found = outcome("result", path)
    kinds = set(content["fields"].values())
    if (
        kinds & {"external", "virtual", "external link", "complex", "text", "field"}
        and not content["left_out"]
    ):
        assert found == "refused", kinds  # a field without its checksum, too
    return found


def _set(group, attributes, changes):
    set_attributes(group, {".": attributes})
    for name, value in changes.items():
        group.attrs[name] = value
