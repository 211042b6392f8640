"""Errata of the paper: formulas and algorithm shown by small computations, area and gap by the rows of our figures and tables."""
