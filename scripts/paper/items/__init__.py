"""The figures and tables of the paper and the items beyond it, in the order of catalogue.toml."""

from ..cases import CATALOGUE
from . import curves, distributions, gap, kappa, load, percolation, stiffness, tables

MODULES = (kappa, gap, load, tables, curves, distributions, percolation, stiffness)
STUDIES = {study.name: study for module in MODULES for study in module.STUDIES}
TEXTS = CATALOGUE["items"]  # {name: title, paper and, for items beyond the paper, question}
