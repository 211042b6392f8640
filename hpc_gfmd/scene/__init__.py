"""The scene: the input of a run, as frozen and validated objects.

`load_scene` reads a TOML file, `Scene.from_toml` a text (as stored in a result file),
`Scene.from_dict` a dictionary. Each raises `SceneError` with one line that names the key, what was
found and what is allowed.
"""

from .model import ArrayScene, Scene
from .read import load_scene, with_overrides
from .settings import LoadTable, Machine, Material, Output, SolverTable
from .surface import File, SelfAffine, Sphere, Wave
from .table import each, has_unit

__all__ = [
    "ArrayScene",
    "File",
    "LoadTable",
    "Machine",
    "Material",
    "Output",
    "Scene",
    "SelfAffine",
    "SolverTable",
    "Sphere",
    "Wave",
    "each",
    "has_unit",
    "load_scene",
    "with_overrides",
]
