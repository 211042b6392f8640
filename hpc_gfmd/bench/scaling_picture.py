"""The picture of `bench scaling`: measured efficiency and shares, and the model's solve time on a cluster."""

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .picture import Rows


def scaling_picture(rows: Rows, model_rows: Rows, folder: str | PathLike) -> None:
    """Draw scaling.png into a folder."""
    from ..plotting.style import COLOURS, figure

    with figure(Path(folder) / "scaling.png", 10.5, 3.4) as fig:
        measured, shares, model = fig.subplots(1, 3)
        _efficiency(measured, rows, COLOURS)
        _shares(shares, [row for row in rows if row["kind"] == "strong"], COLOURS)
        for k, (n, link) in enumerate(dict.fromkeys((row["n"], row["network_gb_per_s"]) for row in model_rows)):
            here = [row for row in model_rows if (row["n"], row["network_gb_per_s"]) == (n, link)]
            model.loglog([row["nodes"] for row in here], [row["seconds"] for row in here], "o-", ms=4, color=COLOURS[k % len(COLOURS)],
                         label=f"$n = 2^{{{round(np.log2(n))}}}$, {link:g} GB/s")
        model.set(xlabel="nodes (model)", ylabel="solve (s)", title="predicted")
        model.legend()


def _efficiency(ax: Any, rows: Rows, colours: Sequence[str]) -> None:
    for k, (kind, precision) in enumerate(dict.fromkeys((row["kind"], row["precision"]) for row in rows)):
        here = [row for row in rows if (row["kind"], row["precision"]) == (kind, precision)]
        for n in dict.fromkeys(row["n"] for row in here) if kind == "strong" else (None,):
            points = [row for row in here if n is None or row["n"] == n]
            ax.plot([row["ranks"] for row in points], [row["efficiency"] for row in points], "o-" if kind == "strong" else "s:", ms=4,
                    color=colours[k % len(colours)], label=f"{kind}, {precision}" + (f", n = {n}" if n else ""))
    ax.set(xlabel="ranks", ylabel="parallel efficiency", title="measured", ylim=(0, 1.2))
    ax.legend(fontsize="x-small")


def _shares(ax: Any, rows: Rows, colours: Sequence[str]) -> None:
    parts = [key for key in rows[0] if key.startswith("share_")] if rows else []
    bottom = np.zeros(len(rows))
    for k, part in enumerate(parts):
        heights = np.array([row[part] for row in rows])
        ax.bar(range(len(rows)), heights, bottom=bottom, color=colours[k % len(colours)], label=part.removeprefix("share_"))
        bottom += heights
    ax.set_xticks(range(len(rows)), [f"{row['n']}\n{row['ranks']} r\n{row['precision'][0]}" for row in rows], fontsize="xx-small")
    ax.set(ylabel="share of the time", title="where it goes")
    ax.legend(fontsize="x-small")
