"""Theory to compare with (NumPy and SciPy only): Persson's, exact elastic and adhesive contacts,
leak rates, corrections to the thermodynamic, fractal and continuum limits.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, ["adhesion", "elastic", "leak", "persson", "reference", "tfc"]
)
