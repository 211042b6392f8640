"""Pictures of rows: lines of those that share some values."""

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
    """y over x of some rows, a line for those that share the values of the keys; scale: of both
    axes."""

    rows: Sequence[dict]
    keys: Sequence[str]
    x: str
    y: str
    title: str = ""
    scale: str = "log"


def picture(path, panels):
    """Draw panels into a file."""
    columns = min(len(panels), 5) or 1
    lines = -(-len(panels) // columns)
    fig = Figure((4 * columns, 4 * lines), layout="constrained")
    names = dict.fromkeys(name for panel in panels for name in group(panel.rows, *panel.keys))
    colours = {name: f"C{k % 10}" for k, name in enumerate(names)}  # the same in all panels
    handles = {}
    for k, panel in enumerate(panels, 1):
        ax = fig.add_subplot(lines, columns, k)
        for name, rows in group(panel.rows, *panel.keys).items():
            points = [row[panel.x] for row in rows], [row[panel.y] for row in rows]
            label = ", ".join(map(str, name))
            (handles[label],) = ax.plot(*points, ".-", color=colours[name], label=label)
        x, y = (LABELS.get(name, name) for name in (panel.x, panel.y))
        ax.set(xlabel=x, ylabel=y, title=panel.title, yscale=panel.scale)
        if not isinstance(panel.rows[0][panel.x], str):
            ax.set_xscale(panel.scale)
    if len({panel.keys for panel in panels}) == 1:  # all have the same lines
        fig.legend(handles.values(), handles, loc="outside lower center", ncols=4)
    else:
        for ax in fig.axes:
            ax.legend(fontsize="xx-small")
    fig.savefig(path, dpi=150)


def group(rows, *keys):
    """Return the rows that share the values of the keys."""
    found = {}
    for row in rows:
        found.setdefault(tuple(row[key] for key in keys), []).append(row)
    return found
