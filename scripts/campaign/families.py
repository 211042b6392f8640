"""All families; importing this module fills the registry."""

from . import closing_walls, defects, formed_walls, free_walls, light_loads, rough_walls, sweeps  # noqa: F401,I001
from . import hard_targets, hard_walls, plastic_walls, sticky_gaps, sticky_walls, target_walls  # noqa: F401
from .registry import FAMILIES, make  # noqa: F401
