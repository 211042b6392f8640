"""Theory to compare with: Persson's theory, exact elastic solutions, adhesive contacts, leak rates,
corrections to the thermodynamic, fractal and continuum limits. NumPy and SciPy only."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__, ["adhesion", "elastic", "leak", "persson", "reference", "tfc"]
)
