"""Pictures of results. Nothing here needs MPI, and no field is ever read whole."""

from .pictures import plot_result

__all__ = ["plot_result"]
