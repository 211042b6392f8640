"""The figures and tables of the paper by what they show: one file for each kind, its entries in
STUDIES; see catalogue."""
