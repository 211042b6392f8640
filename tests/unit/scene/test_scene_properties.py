"""Random tables and overrides give either a Scene or a SceneError of one line."""

from hypothesis import given, settings
from hypothesis import strategies as st
from scene_tables import FILE, SHIPPED, SPHERE, SURFACE, TABLES, WAVE, refusal, tables

from hpc_gfmd.scene import Scene, load_scene
from hpc_gfmd.scene.surface import KINDS
from hpc_gfmd.util.errors import SceneError

OTHER_TABLES = {table: Scene.model_fields[table].annotation for table in TABLES[1:]}
MODELS = [("surface", model) for model in KINDS.values()] + list(OTHER_TABLES.items())
KEYS_OF_TABLES = [(table, key) for table, model in MODELS for key in model.model_fields]
KEYS = sorted({key for _, key in KEYS_OF_TABLES} | set(Scene.model_fields))
SPECIAL = ["auto", "self-affine", "wave", "sphere", "file", "gap", "a.h5", 10**400, 2**63, 1e308]
SCALARS = st.one_of(
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(SPECIAL),
    st.datetimes(),
    st.dates(),
    st.times(),
)
NAMES = st.sampled_from(KEYS) | st.text(max_size=6)


def table_of(values: st.SearchStrategy, size: int) -> st.SearchStrategy:
    """Strategy for tables with known and random keys."""
    return st.dictionaries(NAMES, values, max_size=size)


VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | table_of(inner, 3), max_leaves=6
)


def assert_scene_or_refusal(data: dict) -> None:
    try:
        scene = Scene.from_dict(data)
    except SceneError:
        assert "allowed: " in refusal(data)
    else:
        again = Scene.from_toml(scene.to_toml())
        assert again == scene
        assert again.identity() == scene.identity()
        scene.warnings()


@settings(max_examples=400)
@given(
    st.sampled_from([SURFACE, WAVE, SPHERE, FILE]),
    st.sampled_from(KEYS_OF_TABLES),
    VALUES | st.floats(0, 10) | st.integers(0, 64),
)
def test_changed_value_gives_a_scene_or_a_refusal(surface, place, value):
    data = tables(surface)
    table, key = place
    assert_scene_or_refusal(data | {table: data.get(table, {}) | {key: value}})


@settings(max_examples=400)
@given(st.sampled_from(KEYS) | st.text(max_size=20), st.text(max_size=20))
def test_override_gives_a_scene_or_a_refusal(key, value):
    for override in (f"{key}={value}", f"surface.{key}={value}"):
        message = ""
        try:
            load_scene(SHIPPED[-1], [override])
        except SceneError as error:
            message = str(error)
        assert message.isprintable()
