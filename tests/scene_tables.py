"""Reference scenes as plain tables, for the tests of the scene parser."""

import tomllib
from pathlib import Path

import pytest

import hpc_gfmd.scene
from hpc_gfmd.scene import Scene
from hpc_gfmd.util.errors import SceneError

SHIPPED = sorted((Path(hpc_gfmd.scene.__file__).parents[1] / "scenes").glob("*.toml"))
SURFACE = {
    "kind": "self-affine",
    "hurst": 0.8,
    "L_over_lam_l": 2,
    "lam_l_over_lam_s": 64,
    "lam_s_over_a": 2,
    "seed": 1,
}
WAVE = {"kind": "wave", "amplitude": 0.1, "n": [8, 6]}
SPHERE = {"kind": "sphere", "radius": 1, "n": [8, 8]}
FILE = {"kind": "file", "path": "z.npy"}
TABLES = ("surface", "material", "load", "solver", "output", "machine")


def tables(surface=(), **replaced) -> dict:
    """The reference scene with replaced tables.

    Keys of `surface` replace those of the reference surface, which a `kind` replaces as a whole.
    """
    surface = dict(surface)
    surface = surface if "kind" in surface else SURFACE | surface
    return {"surface": surface, "load": {"p_star": [0.1]}} | replaced


def changed(text: str) -> dict:
    """`tables` with tables in TOML; lines may be separated by " ; "."""
    return tables(**tomllib.loads(text.replace(" ; ", "\n")))


def scene_of(text: str = "") -> Scene:
    """The Scene of `changed`, after checking that it survives a round trip through TOML."""
    scene = Scene.from_dict(changed(text))
    assert Scene.from_toml(scene.to_toml()) == scene
    return scene


def rows(text: str) -> list[tuple[str, ...]]:
    """Rows of a table with columns separated by " | "."""
    return [tuple(map(str.strip, line.split(" | "))) for line in text.strip().splitlines()]


def refusal(data: dict) -> str:
    """The message with which `data` is refused, without the prefix "scene: "."""
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(data)
    message = str(caught.value)
    assert message.isprintable()  # one line
    return message.removeprefix("scene: ")
