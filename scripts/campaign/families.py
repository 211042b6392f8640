"""All families; importing this module fills the registry."""

from . import closing_walls, defects, formed_walls, free_walls, light_loads, rough_walls, sweeps  # noqa: F401

# isort: split
from . import (  # noqa: F401
    hard_targets,
    hard_walls,
    histories,
    hostile_displacements,
    laws,
    plastic_walls,
    sticky_gaps,
    sticky_walls,
    target_walls,
)
from .registry import FAMILIES, make  # noqa: F401
