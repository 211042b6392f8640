"""The pictures of `bench accuracy`: true error against time or FFT pairs, log-log, one panel per load and Hurst exponent.

Solves that were interrupted at their budget are drawn too: with the error that they had reached.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

Rows = Sequence[Mapping[str, Any]]
NAMES = {"bpx": "BPX-GFMD (default)", "gfmd": "GFMD", "fire": "GFMD + FIRE", "ccg": "Polonsky-Keer CG"}
LABELS = {"seconds_min": "time (s)", "cpu_seconds_min": "CPU time (s)", "fft_pairs": "FFT pairs, everything counted"}
MARKERS = {"double": "o", "single": "^"}


def draw(rows: Rows, path: Path, cost: str) -> None:
    """Draw the rows of the largest n of bench_accuracy to path. cost: which of LABELS to draw the error against."""
    from ..plotting.style import COLOURS, figure, ticks

    rows = [row for row in rows if row["error"] and row["status"] in ("converged", "interrupted")]
    if not rows:
        return
    n = max(row["n"] for row in rows)
    rows = [row for row in rows if row["n"] == n]
    loads, hursts, solvers = (list(dict.fromkeys(row[key] for row in rows)) for key in ("p_star", "hurst", "solver"))
    with figure(path, 1.2 + 2.3 * len(loads), 0.9 + 2.3 * len(hursts)) as fig:
        panels = fig.subplots(len(hursts), len(loads), squeeze=False, sharex=True, sharey=True)
        for hurst, line in zip(hursts, panels, strict=True):
            for p_star, ax in zip(loads, line, strict=True):
                here = [row for row in rows if (row["hurst"], row["p_star"]) == (hurst, p_star)]
                _panel(ax, here, solvers, cost, COLOURS)
                ax.set_title(f"$H$ = {hurst:g}, $p^*$ = {p_star:g}")
        for ax in panels[-1]:
            ax.set_xlabel(LABELS[cost])
        ticks(panels[0, 0].xaxis)
        for line in panels:
            line[0].set_ylabel("true relative error")
        _legend(fig, rows, solvers, n, COLOURS)


def _panel(ax: Any, rows: Rows, solvers: Sequence[str], cost: str, colours: Sequence[str]) -> None:
    curves = dict.fromkeys((row["solver"], row["start"], row["precision"]) for row in rows)
    for solver, start, precision in curves:
        points = [row for row in rows if (row["solver"], row["start"], row["precision"]) == (solver, start, precision)]
        ax.loglog([row[cost] for row in points], [row["error"] for row in points], marker=MARKERS[precision], markersize=4,
                  color=colours[solvers.index(solver) % len(colours)], linestyle="-" if start == "nested" else ":",
                  markerfacecolor=None if precision == "double" else "white")


def _legend(fig: Any, rows: Rows, solvers: Sequence[str], n: int, colours: Sequence[str]) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=colours[k % len(colours)], label=NAMES.get(name, name)) for k, name in enumerate(solvers)]
    handles += [Line2D([], [], color="0.3", linestyle="-", label="nested start"),
                Line2D([], [], color="0.3", linestyle=":", label="cold start")]
    handles += [Line2D([], [], color="0.3", linestyle="", marker=MARKERS[p], label=f"{p} precision",
                       markerfacecolor=None if p == "double" else "white") for p in dict.fromkeys(row["precision"] for row in rows)]
    fig.legend(handles=handles, loc="outside upper center", ncols=4,
               title=f"{n} x {n} points; error: worst of area, mean gap, pressure")
