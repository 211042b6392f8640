"""Pictures of results. Nothing here needs MPI, and no field is ever read whole."""

from .pictures import figures, plot_result

__all__ = ["figures", "plot_result"]
