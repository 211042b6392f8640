"""The paper's figures, tables and errata, and questions beyond it: `python scripts/paper ITEM`.

catalogue.toml: which surfaces each item needs, at three levels of effort, and what it is about.
cases: surfaces and loads, and the store of what is solved; solve: what is missing of them;
estimates: from runs to numbers with errors; items/: from there to rows, a picture and a comparison
with what is printed; errata/; rows, pictures, report: how that is written. paper_numbers.json,
printed: what the paper prints. It uses public names of hpc_gfmd alone.
"""
