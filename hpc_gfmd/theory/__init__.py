"""Theory to compare with: Persson's theory, exact elastic solutions, and the corrections to the
thermodynamic, fractal and continuum limits. NumPy and SciPy only."""
