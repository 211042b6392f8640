"""The paper's figures and tables as studies: which contacts each needs, solving what is missing,
tables, pictures, the report.

case: one surface and its loads; levels: how large and how many; catalogue: what a figure or table
is, and all of them, which stand in items/ by what they show; store and runner: solve each contact
once, whoever needs it; publish: tables, pictures and pages. averages, scatter, fits, limits,
coefficients: from runs to rows; rows: choosing among them; draw: pictures; paper: what is printed;
errata/, questions, report: the report.
"""
