"""How all pictures look: colours that colour-blind readers can tell apart, sizes for a journal column."""

import os
from contextlib import contextmanager
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

# Okabe and Ito; the last one is kept for warnings
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#000000")
WARNING = "#D55E00"
THEORY = {"color": "0.35", "linewidth": 1.2}
CONTACT_MAP, PRESSURE_MAP, GAP_MAP = "Greys", "cividis_r", "viridis"

RC = {
    "font.size": 9,
    "axes.labelsize": 9,
    "axes.titlesize": 9,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "lines.linewidth": 1.4,
    "lines.markersize": 5,
    "mathtext.fontset": "dejavusans",
    "savefig.dpi": 200,
}


def shade(x: float):
    """A colour between dark blue (0) and yellow (1), for what varies evenly."""
    return matplotlib.colormaps["viridis"](x)


@contextmanager
def figure(path: Path, width: float, height: float):
    """`with figure(path, width, height) as fig`: drawn by Agg and saved under path in one move; inches."""
    with matplotlib.rc_context(RC):
        fig = Figure(figsize=(width, height), layout="constrained")
        yield fig
        tmp = path.with_name(f".{path.name}.tmp")
        try:
            fig.savefig(tmp, format="png")
            os.replace(tmp, path)
        finally:
            tmp.unlink(missing_ok=True)
