"""Pictures of rows: lines through the rows that share some values."""

from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.figure import Figure

LABELS = {
    "error": "true relative error",
    "fft_pairs": "FFT pairs",
    "seconds_min": "time (s)",
    "peak_mib": "memory (MiB)",
}


class Panel(NamedTuple):
    """A plot of one column of rows against another.

    Attributes
    ----------
    rows : sequence of dict
        The data.
    keys : sequence of str
        Columns that tell lines apart.
    x, y : str
        Columns of the axes.
    title : str
        Title of the panel.
    """

    rows: Sequence[dict]
    keys: Sequence[str]
    x: str
    y: str
    title: str = ""


def picture(path, panels):
    """Draw panels with the same lines into a file, at most five beside each other."""
    columns = min(len(panels), 5) or 1
    lines = -(-len(panels) // columns)
    fig = Figure((4 * columns, 4 * lines), layout="constrained")
    names = dict.fromkeys(name for panel in panels for name in group(panel.rows, *panel.keys))
    colours = {name: f"C{k % 10}" for k, name in enumerate(names)}  # the same in all panels
    handles = {}
    for k, panel in enumerate(panels, 1):
        ax = fig.add_subplot(lines, columns, k)
        for name, rows in group(panel.rows, *panel.keys).items():
            x = [row[panel.x] for row in rows]
            y = [row[panel.y] for row in rows]
            label = ", ".join(map(str, name))
            (handles[label],) = ax.plot(x, y, ".-", color=colours[name], label=label)
        ax.set_xlabel(LABELS.get(panel.x, panel.x))
        ax.set_ylabel(LABELS.get(panel.y, panel.y))
        ax.set(title=panel.title, yscale="log")
        if not isinstance(panel.rows[0][panel.x], str):
            ax.set_xscale("log")
    fig.legend(handles.values(), handles, loc="outside lower center", ncols=4)
    fig.savefig(path, dpi=150)


def group(rows, *keys):
    """Return {values of the keys: rows that share them}, in the order of the rows."""
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups
