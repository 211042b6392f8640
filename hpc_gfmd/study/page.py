"""The page of a study beyond the paper: question, picture, what we find, numbers, command, time. Markdown."""

from .. import __version__
from .markdown import literal
from .rows import Rows
from .study import Study

PAGE = """# {title}

{question}

![{title}]({name}.png)

{found}

{numbers}

All numbers: [{name}.csv]({name}.csv), [{name}.json]({name}.json). "±" is one standard error.

Made by `hpc-gfmd study {name} --level {level}` (hpc_gfmd {version}): {loads} loads on {surfaces} surfaces, grids from {low}² to {high}²
points, {minutes:.0f} minutes of solving in all, on one shared core; {poor} loads failed their accuracy of {accuracy:g}.
"""


def page(study: Study, rows: Rows, runs: Rows, level: str) -> str:
    """The text; runs: those that the rows are made of."""
    lines = study.compare(rows)
    found = "\n".join(f"- {literal(line['paper'])}: **{literal(line['ours'])}**" + (f" ({literal(line['why'])})" if line["why"] else "")
                      for line in lines)
    sizes = [run["n"] for run in runs]
    return PAGE.format(
        title=study.title, name=study.name, question=study.question, found=found, level=level, version=__version__,
        numbers=study.numbers(rows) if study.numbers else "", loads=len(runs),
        surfaces=len({(run["hurst"], run["seed"], run["eps_t"], run["eps_f"]) for run in runs}), low=min(sizes), high=max(sizes),
        minutes=sum(run["wall_seconds"] for run in runs) / 60, poor=sum(run["status"] != "converged" for run in runs),
        accuracy=max(run["accuracy"] for run in runs))
