"""The paper's figures, tables and errata, and questions beyond it: `python scripts/paper ITEM`.

catalogue.toml               texts of the items and the surfaces that they need, at three levels of
                             effort
cases, solve                 surfaces and loads, the store of solved ones; solving the missing ones
estimates                    from runs to numbers with standard errors
items/, errata/              from there to rows, pictures and comparisons with the paper
rows, pictures, report       how these are written
paper_numbers.json, printed  the numbers that the paper prints

Only public names of hpc_gfmd are used.
"""
