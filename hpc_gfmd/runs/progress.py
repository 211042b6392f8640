"""What a person sees while a run works: a bar on a terminal, plain lines in a batch job. Only rank
0 speaks."""

import math
import os
import sys
import time
from typing import Any

from ..parallel.comm import Comm
from ..scene import Solver
from ..solvers.base import Progress
from ..util.streams import Stream

LINE_SECONDS = 10.0  # between two log lines of one load step


class Reporter:
    """say(text) prints a line; step(...) begins a load step; watch(iterations, progress) after
    every iteration; done() ends it.

    bar: whether a bar is drawn; None: on a terminal and in a notebook. out: where lines go.
    """

    def __init__(
        self,
        comm: Comm,
        target: Solver,
        quiet: bool = False,
        bar: bool | None = None,
        out: Any = None,
    ):
        self.silent = comm.rank != 0 or quiet
        self.out, self.err = Stream(out or sys.stdout), Stream(sys.stderr)
        seen = self.err.isatty() or "ipykernel" in sys.modules
        wanted = os.environ.get("HPC_GFMD_PROGRESS") or ("bar" if seen else "log")
        self.bar_wanted = (wanted == "bar" if bar is None else bar) and not self.silent
        self.target = target
        self.bar: Any = None

    def say(self, text: str) -> None:
        if not self.silent:
            print(text, file=self.out, flush=True)

    def step(self, index: int, count: int, quantity: str, value: float) -> None:
        self.name = f"load {index + 1}/{count}, {quantity} = {value:.4g}"
        self.begun = self.last = time.monotonic()
        self.first: float | None = None
        if self.bar_wanted:
            from tqdm.auto import tqdm  # in a notebook one of its own

            self.bar = tqdm(
                total=1.0,
                desc=self.name,
                leave=False,
                file=self.err,
                bar_format="{desc} |{bar}| {postfix} {elapsed}",
            )

    def watch(self, iterations: int, progress: Progress) -> None:
        if self.silent:
            return
        error = (
            progress.residual
            if self.target.residual is not None
            else max(progress.estimates or (progress.residual,))
        )
        wanted = self.target.tolerance
        said = f"iteration {iterations}, error {error:.1e} (wanted {wanted:.0e})"
        if self.bar is not None:
            if 0 < error < math.inf:
                self.first = self.first or error
                if self.first > wanted:
                    done = math.log(self.first / error) / math.log(self.first / wanted)
                    self.bar.n = min(max(done, self.bar.n), 1.0)
            self.bar.set_postfix_str(said)
        elif time.monotonic() - self.last > LINE_SECONDS:
            self.last = time.monotonic()
            self.say(f"{self.name}: {said}, {self.last - self.begun:.0f} s")

    def done(self) -> None:
        if self.bar is not None:
            self.bar.close()
            self.bar = None
