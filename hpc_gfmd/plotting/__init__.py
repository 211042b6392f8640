"""Pictures of results and surfaces, without MPI; fields are read a few rows at a time.

The names are listed in __init__.pyi; Matplotlib is imported when one of them is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
