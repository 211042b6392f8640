"""What a person sees while a run works: a progress bar on a terminal, lines in a batch job."""

import math
import os
import sys
import time
from typing import Any

from ..parallel.ancestors import launcher_is_watched
from ..parallel.comm import Comm
from ..scene import SolverTable
from ..solvers.base import Progress
from ..util.streams import discard

LINE_SECONDS = 10.0  # between two lines about one load


class Reporter:
    """Prints how far a run has got, on rank 0 alone.

    A line that cannot be printed is lost and so is all that follows; the run goes on.

    Parameters
    ----------
    comm : Comm
        Communicator of the run.
    target : SolverTable
        Table [solver] of the scene, with the accuracy or the residual that is asked for.
    quiet : bool
        Print nothing.
    bar : bool, optional
        Whether to draw a bar; by default on a terminal and in a notebook, or as the environment
        variable HPC_GFMD_PROGRESS ("bar" or "log") says.
    out : file, optional
        Where lines go; by default standard output.
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
            is_watched = _is_terminal(sys.stderr) or "ipykernel" in sys.modules
            is_watched = is_watched or (comm.size > 1 and launcher_is_watched())
            style = os.environ.get("HPC_GFMD_PROGRESS") or ("bar" if is_watched else "log")
            bar = style == "bar"
        self.draws_bar = bar and not self.silent and sys.stderr is not None
        self.bar: Any = None

    def say(self, text: str) -> None:
        """Print one line."""
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

    def step(self, index: int, count: int, quantity: str, value: float) -> None:
        """Begin a load.

        Parameters
        ----------
        index : int
            Its number, from 0.
        count : int
            Number of loads of the run.
        quantity : str
            What is prescribed, such as "p_star".
        value : float
            Its value.
        """
        self.name = f"load {index + 1}/{count}, {quantity} = {value:.4g}"
        self.begin_time = time.monotonic()
        self.line_time = self.begin_time
        self.first_error: float | None = None
        if self.draws_bar:
            from tqdm.auto import tqdm  # in a notebook a widget

            try:
                self.bar = tqdm(
                    total=1.0,
                    desc=self.name,
                    leave=False,
                    file=sys.stderr,
                    bar_format="{desc} |{bar}| {postfix} {elapsed}",
                )
            except (OSError, ValueError):
                self._drop_bar()

    def watch(self, iterations: int, progress: Progress) -> None:
        """Report on the load after an iteration.

        Parameters
        ----------
        iterations : int
            Iterations of this load so far.
        progress : Progress
            What the solver knows of its accuracy.
        """
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
        """Move the bar to the part of the way, in decades of the error, that is done."""
        wanted = self.target.tolerance
        if 0 < error < math.inf:
            self.first_error = self.first_error or error
            if self.first_error > wanted:
                part = math.log(self.first_error / error) / math.log(self.first_error / wanted)
                self.bar.n = min(max(part, self.bar.n), 1.0)
        self.bar.set_postfix_str(text)

    def done(self) -> None:
        """End the load: remove its bar."""
        if self.bar is not None:
            try:
                self.bar.close()
            except (OSError, ValueError):
                discard(sys.stderr)
            self.bar = None

    def _drop_bar(self) -> None:
        """Do without bars from here on."""
        discard(sys.stderr)
        self.bar = None
        self.draws_bar = False


def _is_terminal(stream: Any) -> bool:
    """Return whether a stream is a terminal."""
    try:
        return bool(stream.isatty())
    except (AttributeError, OSError, ValueError):  # None, or closed
        return False
