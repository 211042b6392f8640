"""The pictures of `bench accuracy` and `bench scaling`."""

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from hpc_gfmd.plotting.style import COLOURS, figure, ticks

Rows = Sequence[Mapping[str, Any]]
NAMES = {
    "bpx": "BPX-GFMD (default)",
    "gfmd": "GFMD",
    "fire": "GFMD + FIRE",
    "ccg": "Polonsky-Keer CG",
}
LABELS = {
    "seconds_min": "time (s)",
    "cpu_seconds_min": "CPU time (s)",
    "fft_pairs": "FFT pairs, everything counted",
}
MARKERS = {"double": "o", "single": "^"}


def accuracy_picture(rows: Rows, path: Path, cost: str) -> None:
    """Draw the rows of the largest n of bench_accuracy to path: true error against time or FFT
    pairs, log-log, a panel for each load and Hurst exponent. Solves that were interrupted at their
    budget have the error that they had reached. cost: which of LABELS."""
    rows = [row for row in rows if row["error"] and row["status"] in ("converged", "interrupted")]
    if not rows:
        return
    n = max(row["n"] for row in rows)
    rows = [row for row in rows if row["n"] == n]
    loads, hursts, solvers = (
        list(dict.fromkeys(row[key] for row in rows)) for key in ("p_star", "hurst", "solver")
    )
    with figure(path, 1.2 + 2.3 * len(loads), 0.9 + 2.3 * len(hursts)) as fig:
        panels = fig.subplots(len(hursts), len(loads), squeeze=False, sharex=True, sharey=True)
        for hurst, line in zip(hursts, panels, strict=True):
            for p_star, ax in zip(loads, line, strict=True):
                here = [row for row in rows if (row["hurst"], row["p_star"]) == (hurst, p_star)]
                _panel(ax, here, solvers, cost)
                ax.set_title(f"$H$ = {hurst:g}, $p^*$ = {p_star:g}")
        for ax in panels[-1]:
            ax.set_xlabel(LABELS[cost])
        ticks(panels[0, 0].xaxis)
        for line in panels:
            line[0].set_ylabel("true relative error")
        _legend(fig, rows, solvers, n)


def _panel(ax: Any, rows: Rows, solvers: Sequence[str], cost: str) -> None:
    curves = dict.fromkeys((row["solver"], row["start"], row["precision"]) for row in rows)
    for solver, start, precision in curves:
        points = [
            row
            for row in rows
            if (row["solver"], row["start"], row["precision"]) == (solver, start, precision)
        ]
        ax.loglog(
            [row[cost] for row in points],
            [row["error"] for row in points],
            marker=MARKERS[precision],
            markersize=4,
            color=COLOURS[solvers.index(solver) % len(COLOURS)],
            linestyle="-" if start == "nested" else ":",
            markerfacecolor=None if precision == "double" else "white",
        )


def _legend(fig: Any, rows: Rows, solvers: Sequence[str], n: int) -> None:
    handles = [
        Line2D([], [], color=COLOURS[k % len(COLOURS)], label=NAMES.get(name, name))
        for k, name in enumerate(solvers)
    ]
    handles += [
        Line2D([], [], color="0.3", linestyle="-", label="nested start"),
        Line2D([], [], color="0.3", linestyle=":", label="cold start"),
    ]
    handles += [
        Line2D(
            [],
            [],
            color="0.3",
            linestyle="",
            marker=MARKERS[p],
            label=f"{p} precision",
            markerfacecolor=None if p == "double" else "white",
        )
        for p in dict.fromkeys(row["precision"] for row in rows)
    ]
    fig.legend(
        handles=handles,
        loc="outside upper center",
        ncols=4,
        title=f"{n} x {n} points; error: worst of area, mean gap, pressure",
    )


def scaling_picture(rows: Rows, model_rows: Rows, folder: str | PathLike) -> None:
    """Draw scaling.png into a folder: measured efficiency and shares, and the model's solve time on
    a cluster."""
    with figure(Path(folder) / "scaling.png", 10.5, 4.0) as fig:
        measured, shares, model = fig.subplots(1, 3)
        series = _series(rows, "kind", "precision", "n")
        for (kind, precision, n), points in series.items():
            measured.semilogx(
                [row["ranks"] * row["threads"] for row in points],
                [row["efficiency"] for row in points],
                {"strong": "o-", "weak": "s--"}.get(kind, "^:"),
                base=2,
                label=f"{kind}, $n = {n}$, {precision}",
            )
        measured.set(xlabel="cores", ylabel="parallel efficiency", title="measured", ylim=(0, 1.1))
        _shares(shares, [row for row in rows if row["kind"] == "strong"])
        for (n, link), points in _series(model_rows, "n", "network_gb_per_s").items():
            model.loglog(
                [row["nodes"] for row in points],
                [row["seconds"] for row in points],
                "o-",
                label=f"$n = 2^{{{round(np.log2(n))}}}$, {link:g} GB/s",
            )
        model.set(xlabel="nodes", ylabel="solve (s)", title="predicted by the model")
        for ax in (measured, model):
            ax.xaxis.set_major_formatter("{x:g}")
        for ax in (measured, shares, model):
            for k, line in enumerate(ax.lines):
                line.set_color(COLOURS[k % len(COLOURS)])
            ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2)


def _series(rows: Rows, *keys: str) -> dict[tuple[Any, ...], list[Mapping[str, Any]]]:
    """The rows that share the values of the keys."""
    found: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        found.setdefault(tuple(row[key] for key in keys), []).append(row)
    return found


def _shares(ax: Any, rows: Rows) -> None:
    parts = [key for key in rows[0] if key.startswith("share_")] if rows else []
    bottom = np.zeros(len(rows))
    for part, colour in zip(parts, COLOURS, strict=False):
        heights = np.array([row[part] for row in rows])
        name = part.removeprefix("share_").replace("fft", "FFT")
        ax.bar(range(len(rows)), heights, bottom=bottom, color=colour, label=name)
        bottom += heights
    ax.set_xticks(range(len(rows)), [row["ranks"] for row in rows])
    ax.tick_params("x", length=0)
    for (n, precision), members in _series(rows, "n", "precision").items():
        middle = rows.index(members[0]) + (len(members) - 1) / 2
        ax.annotate(f"$n = {n}$, {precision}", (middle, 1.02), ha="center")
    ax.set(xlabel="ranks", ylabel="share of the time", title="where it goes", ylim=(0, 1.1))
