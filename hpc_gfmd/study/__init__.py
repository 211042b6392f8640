"""The paper's figures and tables as studies: which contacts each needs, solving what is missing, tables, pictures, the report.

case: one surface and its loads; levels: how large and how many; items/: one file per figure or table, found by catalogue;
store and runner: solve each contact once, whoever needs it; publish: tables and pictures of what is stored.
averages, scatter, fits, limits, coefficients: from runs to rows; draw: pictures; paper, compare: what is printed beside what we find;
errata_*, questions, report: the report.
"""
