"""Families with a hardness of 0.1 to 10 times the largest elastic pressure."""

from dataclasses import replace

from .registry import FAMILIES
from .shapes import log_uniform


def _hard(kind):
    def make_wall(rng):
        hardness = log_uniform(rng, 0.1, 10.0)
        return replace(FAMILIES[kind](rng), hardness=hardness)

    return make_wall


for _name, _kind in {
    "hard_rough": "self_affine",
    "hard_smooth": "self_affine_smooth",
    "hard_noise": "white_noise",
    "hard_sphere": "rough_sphere",
    "hard_punches": "punches",
    "hard_lattice": "lattice_noise",
    "hard_scene": "scene",
    "sweep_hard": "sweep_rough",
    "free_hard": "free_rough",
}.items():
    FAMILIES[_name] = _hard(_kind)
