"""The paper's figures and tables as studies: which contacts each needs, solving what is missing, tables, pictures, the report.

case: one surface and its loads; levels: how large and how many; study: what a figure or table is; items/: all of them, by what they
show, found by catalogue; store and runner: solve each contact once, whoever needs it; publish: tables and pictures of what is stored.
averages, scatter, fits, limits, coefficients: from runs to rows; rows: choosing among them; draw: pictures; paper: what is printed;
errata/, questions, report: the report.
"""
