"""The page of a study beyond the paper: question, picture, what we find, numbers, command, time. Markdown."""

from typing import Any

from .. import __version__
from .rows import Rows
from .study import Study
from .text import literal, table

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
    found = "\n".join(f"- {literal(line['paper'])}: **{literal(line['ours'])}**" + (f" ({literal(line['why'])})" if line["why"] else "")
                      for line in study.compare(rows))
    surfaces = {(run["hurst"], run["seed"], run["eps_t"], run["eps_f"]) for run in runs}
    return PAGE.format(name=study.name, title=study.title, question=study.question, found=found, level=level, version=__version__,
                       numbers=table(study.lines(rows), study.columns), surfaces=len(surfaces), **effort(runs))


def effort(runs: Rows) -> dict[str, Any]:
    """What runs took: loads, low and high (points along an axis), minutes, poor (loads that failed their accuracy), accuracy."""
    sizes = [run["n"] for run in runs] or [0]
    return {"loads": len(runs), "low": min(sizes), "high": max(sizes), "minutes": sum(run["wall_seconds"] for run in runs) / 60,
            "poor": sum(run["status"] != "converged" for run in runs), "accuracy": max((run["accuracy"] for run in runs), default=0)}
