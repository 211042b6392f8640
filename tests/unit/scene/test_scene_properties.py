"""Whatever a scene holds, it becomes a Scene or a SceneError of one line."""

import tomli_w
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scene_tables import FILE, SHIPPED, SPHERE, SURFACE, TABLES, WAVE, refusal, tables

from hpc_gfmd.scene import Scene, load_scene
from hpc_gfmd.scene.surface import KINDS
from hpc_gfmd.util.errors import SceneError

MODELS = [Scene, *KINDS.values(), *(Scene.model_fields[table].annotation for table in TABLES[1:])]
KEYS = sorted({key for model in MODELS for key in model.model_fields})
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
PLACES = st.sampled_from(
    [
        (table, key)
        for table, models in zip(
            TABLES, [list(KINDS.values()), *([m] for m in MODELS[1 + len(KINDS) :])]
        )
        for model in models
        for key in model.model_fields
    ]
)
NAMES = st.sampled_from(KEYS) | st.text(max_size=6)


def table_of(values: st.SearchStrategy, size: int) -> st.SearchStrategy:
    return st.dictionaries(NAMES, values, max_size=size)


VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | table_of(inner, 3), max_leaves=6
)
quick = settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def survives(data: dict) -> None:
    try:
        scene = Scene.from_dict(data)
    except SceneError:
        assert "allowed: " in refusal(data)
    else:
        assert Scene.from_toml(scene.to_toml()) == scene
        assert len(scene.identity()) == 64
        scene.warnings()


@quick
@given(
    st.sampled_from([SURFACE, WAVE, SPHERE, FILE]),
    PLACES,
    VALUES | st.floats(0, 10) | st.integers(0, 64),
)
def test_one_changed_value_gives_a_scene_or_a_scene_error(surface, place, value):
    data, (table, key) = tables(surface), place
    survives(data | {table: data.get(table, {}) | {key: value}})


@quick
@given(st.sampled_from(KEYS) | st.text(max_size=20), st.text(max_size=20))
def test_any_override_gives_a_scene_or_a_scene_error(key, value):
    for override in (f"{key}={value}", f"surface.{key}={value}"):
        message = ""
        try:
            load_scene(SHIPPED[-1], [override])
        except SceneError as error:
            message = str(error)
        assert message.isprintable()


positive = st.floats(1e-100, 1e100)
ratio = st.integers(1, 64) | st.sampled_from([1.5, 2.5, 12.5])
some_title = st.text(max_size=30).filter(str.isprintable)
poisson = st.floats(-0.99, 0.5)
finite = st.floats(allow_nan=False, allow_infinity=False)
rms = st.sampled_from([{}, {"g_rms": 0.1}, {"h_rms": 3e-9}])
surfaces = st.one_of(
    st.fixed_dictionaries(
        {
            "kind": st.just("self-affine"),
            "hurst": st.floats(0, 1),
            "L_over_lam_l": st.integers(1, 64),
            "lam_l_over_lam_s": ratio.map(lambda x: 2 * x),
            "lam_s_over_a": st.integers(2, 64),
            "seed": st.integers(0, 2**63 - 1),
        },
        optional={"physical_sizes": st.sampled_from([[1, 2], [3e-6, 3e-6]])},
    ).flatmap(lambda table: rms.map(lambda one: table | one)),
    st.fixed_dictionaries(
        {
            "kind": st.just("wave"),
            "amplitude": st.floats(0.001, 1e100),
            "n": st.lists(st.integers(8, 5000), min_size=2, max_size=2),
        },
        optional={"periods": st.sampled_from([[1, 0], [0, 3], [4, 4]])},
    ),
    st.fixed_dictionaries(
        {"kind": st.just("sphere"), "radius": positive, "n": st.just([3, 7])},
        optional={"physical_sizes": st.tuples(positive, positive).map(list)},
    ),
    st.fixed_dictionaries(
        {"kind": st.just("file"), "path": some_title.filter(bool)},
        optional={"dataset": st.just("a/b")},
    ),
)
valid = st.fixed_dictionaries(
    {
        "surface": surfaces,
        "load": st.sampled_from(["p_star", "pressure"]).flatmap(
            lambda key: (positive | st.lists(positive, min_size=1, max_size=4)).map(
                lambda load: {key: load}
            )
        ),
    },
    optional={
        "title": some_title,
        "material": st.one_of(
            st.fixed_dictionaries({"E_star": positive}),
            st.fixed_dictionaries({"E1": st.floats(1e-9, 1e12), "nu1": poisson}),
            st.fixed_dictionaries(
                {
                    "E_star": positive,
                    "nu1": poisson,
                    "thickness": positive,
                    "base": st.just("frictionless"),
                }
            ),
            st.fixed_dictionaries(
                {
                    "E1": st.floats(1e-9, 1e12),
                    "nu1": poisson,
                    "E2": st.integers(1, 10**12),
                    "nu2": poisson,
                }
            ),
        ),
        "solver": st.fixed_dictionaries(
            {},
            optional={
                "name": some_title,
                "residual": st.floats(1e-300, 0.5),
                "precision": st.sampled_from(["single", "double"]),
                "max_iterations": st.integers(1, 2**63 - 1),
                "nested": st.just("auto") | st.booleans(),
                "low_memory": st.booleans(),
                "options": st.dictionaries(
                    st.text(max_size=5), st.integers(-(2**63) + 1, 2**63 - 1) | finite, max_size=3
                ),
            },
        ),
        "output": st.fixed_dictionaries(
            {},
            optional={
                "path": some_title.map(lambda name: f"{name}x.h5"),
                "compression": st.booleans(),
                "fields": st.lists(
                    st.sampled_from(["pressure", "gap", "displacement"]), unique=True
                ),
                "observables": st.lists(some_title.filter(bool), unique=True, max_size=3),
                "dtype": st.sampled_from(["single", "double"]),
            },
        ),
        "machine": st.fixed_dictionaries(
            {},
            optional={
                "threads": st.just("auto") | st.integers(1, 64),
                "wall_seconds": positive,
                "checkpoint_seconds": positive,
                "memory_gib": positive,
            },
        ),
    },
)


@quick
@given(valid)
def test_valid_scenes_survive_a_round_trip(data):
    scene = Scene.from_dict(data)
    again = Scene.from_toml(scene.to_toml())
    assert again == scene
    assert again.identity() == scene.identity()
    assert Scene.from_toml(tomli_w.dumps(data)) == scene
