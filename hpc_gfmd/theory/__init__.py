"""Theory to compare with: Persson's theory, exact elastic solutions, leak rates, corrections to the
thermodynamic, fractal and continuum limits. NumPy and SciPy only."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, ["elastic", "leak", "persson", "reference", "tfc"]
)
