"""All families: importing this fills the registry."""

from . import (  # noqa: F401
    closing_walls,
    defects,
    formed_walls,
    free_walls,
    light_loads,
    rough_walls,
    sweeps,
)
from .registry import FAMILIES, make  # noqa: F401
