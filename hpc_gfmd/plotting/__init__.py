"""Pictures of results and surfaces, without MPI; fields are read a few rows at a time."""

from .maps import height_map
from .pictures import chosen_steps, figures, plot, plot_result

__all__ = ["chosen_steps", "figures", "height_map", "plot", "plot_result"]
