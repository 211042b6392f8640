"""Progress of a run for a person: a bar on a terminal, lines in a batch job."""

import math
import os
import sys
import time
from importlib.util import find_spec
from typing import Any

from ..parallel.comm import Comm
from ..parallel.launcher import launcher_is_watched
from ..scene import SolverTable
from ..solvers.base import Progress
from ..util.notebook import in_notebook
from ..util.streams import discard

LINE_SECONDS = 10.0  # between two lines about one load


class Reporter:
    """Prints progress on rank 0 until a line cannot be printed; bars by default on a terminal, in a
    notebook, or by HPC_GFMD_PROGRESS ("bar" or "log").
    """

    def __init__(
        self,
        comm: Comm,
        target: SolverTable,
        quiet: bool = False,
        bar: bool | None = None,
        out: Any = None,
    ):
        self.silent = comm.rank != 0 or quiet
        self.target = target
        self.out = out or sys.stdout
        if bar is None:
            is_watched = _is_terminal(sys.stderr) or in_notebook()
            is_watched = is_watched or (comm.size > 1 and launcher_is_watched())
            style = os.environ.get("HPC_GFMD_PROGRESS") or ("bar" if is_watched else "log")
            bar = style == "bar"
        self.draws_bar = bar and not self.silent and bar_stream() is not None
        self.bar: Any = None

    def say(self, text: str) -> None:
        """Print one line, on rank 0 unless quiet. Never raises for a stream that fails."""
        if self.silent or self.out is None:
            return
        encoding = getattr(self.out, "encoding", None) or "utf-8"
        try:
            print(
                text.encode(encoding, "backslashreplace").decode(encoding),
                file=self.out,
                flush=True,
            )
        except (OSError, ValueError):  # ValueError: the stream is closed
            discard(self.out)
            self.out = None

    def step(self, name: str) -> None:
        """Begin to report on a load by its name: "load 1/2, p* = 0.05"."""
        self.name = name
        self.begin_time = time.monotonic()
        self.line_time = self.begin_time
        self.first_error: float | None = None
        if self.draws_bar:
            try:
                self.bar = new_bar(self.name, 1.0, "{desc} |{bar}| {postfix} {elapsed}")
            except (OSError, ValueError):
                self._drop_bar()

    def watch(self, iterations: int, progress: Progress) -> None:
        """Report on the load after an iteration: move the bar, or print a line now and then."""
        if self.silent:
            return
        error = progress.residual
        if self.target.residual is None and progress.estimates:
            error = max(progress.estimates)
        text = f"iteration {iterations}, error {error:.1e} (wanted {self.target.tolerance:.0e})"
        now = time.monotonic()
        if self.bar is not None:
            try:
                self._draw(error, text)
            except (OSError, ValueError):
                self._drop_bar()
        elif now - self.line_time > LINE_SECONDS:
            self.line_time = now
            self.say(f"{self.name}: {text}, {now - self.begin_time:.0f} s")

    def _draw(self, error: float, text: str) -> None:
        """Advance the bar, never back, to the share of decades from the first to the last error."""
        wanted = self.target.tolerance
        if 0 < error < math.inf:
            self.first_error = self.first_error or error
            if self.first_error > wanted:
                part = math.log(self.first_error / error) / math.log(self.first_error / wanted)
                self.bar.n = min(max(part, self.bar.n), 1.0)
        self.bar.set_postfix_str(text)

    def done(self) -> None:
        """End the report on a load and remove its bar, if there is one."""
        if self.bar is not None:
            try:
                self.bar.close()
            except (OSError, ValueError):
                discard(bar_stream())
            self.bar = None

    def _drop_bar(self) -> None:
        """Draw no more bars, after the stream has failed."""
        discard(bar_stream())
        self.bar = None
        self.draws_bar = False


def bar_stream() -> Any:
    """Return standard error, or standard output in a notebook, which colours the former."""
    return sys.stdout if in_notebook() else sys.stderr


def new_bar(name: str, total: float | None, bar_format: str | None = None) -> Any:
    """Draw a bar, full at `total`, that disappears when closed; a widget in a notebook with
    ipywidgets. OSError or ValueError if it cannot be printed.
    """
    if in_notebook() and find_spec("ipywidgets"):
        from tqdm.notebook import tqdm
    else:
        from tqdm import tqdm
    return tqdm(desc=name, total=total, bar_format=bar_format, leave=False, file=bar_stream())


def _is_terminal(stream: Any) -> bool:
    """Whether a stream is a terminal; False for None and for a closed stream."""
    try:
        return bool(stream.isatty())
    except (AttributeError, OSError, ValueError):  # None, or closed
        return False
