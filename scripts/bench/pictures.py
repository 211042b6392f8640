"""Pictures of rows: lines of those that share some values."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from .timing import Row

Rows = Sequence[Row]


def accuracy_picture(rows: Rows, path: Path, cost: str) -> None:
    """Draw the rows of the largest n of accuracy.py to path: true error (worst of area, mean gap,
    pressure) against cost, a panel for each load and Hurst exponent."""
    n = max((row["n"] for row in rows), default=0)
    panels = group([row for row in rows if row["n"] == n and row["error"]], "hurst", "p_star")
    with _panels(path, len(panels)) as axes:
        for ax, ((hurst, p_star), members) in zip(axes, panels.items(), strict=True):
            lines(ax, members, ("solver", "start", "precision"), cost, "error")
            ax.set(xscale="log", yscale="log", title=f"n = {n}, H = {hurst:g}, p* = {p_star:g}")


def scaling_picture(rows: Rows, model: Rows, path: Path) -> None:
    """Draw measured efficiency, the share of messages, and the model's solve time on a cluster."""
    rows = [row | {"cores": row["ranks"] * row["threads"]} for row in rows]
    with _panels(path, 3) as (measured, shares, predicted):
        for ax, what in ((measured, "efficiency"), (shares, "share_messages")):
            lines(ax, rows, ("kind", "n", "precision"), "cores", what)
            ax.set(xscale="log", ylim=(0, 1.1))
        lines(predicted, model, ("n", "link_gb_per_s"), "nodes", "seconds")
        predicted.set(xscale="log", yscale="log", title="predicted by the model")


def releases_picture(rows: Rows, path: Path) -> None:
    """Draw time, pairs and memory of every scene over the releases."""
    with _panels(path, 3) as axes:
        for ax, what in zip(axes, ("seconds_min", "fft_pairs", "peak_mib"), strict=True):
            lines(ax, rows, ("scene", "n"), "release", what)


def group(rows: Rows, *keys: str) -> dict[tuple, list[Row]]:
    """Return the rows that share the values of the keys."""
    found: dict[tuple, list[Row]] = {}
    for row in rows:
        found.setdefault(tuple(row[key] for key in keys), []).append(row)
    return found


def lines(ax: Any, rows: Rows, keys: Sequence[str], x: str, y: str) -> None:
    """Draw y over x, a line for those that share the values of the keys."""
    for name, members in group(rows, *keys).items():
        points = [row[x] for row in members], [row[y] for row in members]
        ax.plot(*points, ".-", label=", ".join(map(str, name)))
    ax.set(xlabel=x, ylabel=y)
    ax.legend(title=", ".join(keys), fontsize="xx-small")


@contextmanager
def _panels(path: Path, count: int) -> Iterator[Sequence[Any]]:
    """`with _panels(path, count) as axes`: what is drawn there becomes the file."""
    rows, columns = -(-max(count, 1) // 5), min(count, 5)
    fig = Figure((4 * columns, 4 * rows), layout="constrained")
    yield [fig.add_subplot(rows, columns, k + 1) for k in range(count)]
    fig.savefig(path, dpi=150)
