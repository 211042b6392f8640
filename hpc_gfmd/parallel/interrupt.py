"""Requests to stop: signals and the wall-clock budget, agreed on by all ranks."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import SimpleNamespace
from typing import Any, Self

from ..util.errors import SceneError
from .comm import Comm

HANDLED = tuple(  # as far as the system has them; SIGUSR1: the batch system's warning
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGUSR1") if hasattr(signal, name)
)

_running: "Interrupt | None" = None  # the Interrupt that listens: signals are sent to the process


class Stopped(Exception):
    """The run is to stop because of a signal (its number), between two iterations. Exit code: 130
    after SIGINT, else (other signals, deadline) 143.
    """

    def __init__(self, number: int):
        super().__init__(f"stopped by signal {number}")
        self.number = number
        self.exit_code = 130 if number == signal.SIGINT else 143


def check(comm: Comm) -> None:
    """Raise Stopped on all ranks of a communicator if one was sent a signal and an Interrupt
    listens. Collective. The deadline is left to `poll`, so that a run comes to an iteration and
    keeps its gap.
    """
    whole: Any = comm
    while whole.parent is not None:
        whole = whole.parent
    if (
        _running is not None
        and whole is _running.comm
        and (number := int(comm.max([_running.signal])[0]))
    ):
        raise Stopped(number)


@contextmanager
def shared(comm: Comm, value: Any) -> Iterator[SimpleNamespace]:
    """A block in which only some ranks, rank 0 among them, have work: its `value` is then that of
    rank 0 on all, and Stopped is raised on all. Collective.
    """
    result = SimpleNamespace(value=value)
    number = 0
    try:
        yield result
    except Stopped as stopped:
        number = stopped.number
    result.value, number = comm.bcast((result.value, number))
    if number:
        raise Stopped(number)


class Interrupt:
    """Listens for signals (in the main thread) and a deadline in seconds, in a `with` block.

    A first signal is noted in `signal` and announced at once, as mpirun leaves its ranks a second;
    a second one ends the process.
    """

    def __init__(
        self,
        comm: Comm,
        deadline: float | None = None,
        announce: Callable[[], object] | None = None,
    ):
        self.comm = comm
        self.announce = announce
        self.begun = time.monotonic()
        self.deadline = deadline
        self.signal = 0

    def __enter__(self) -> Self:
        global _running
        _running = self
        self._before: dict[int, Any] = {}
        try:
            for s in HANDLED:
                self._before[s] = signal.signal(s, self._note)
        except ValueError:  # not in the main thread: somebody else handles signals
            pass
        return self

    def __exit__(self, *_: object) -> None:
        global _running
        _running = None
        for s, handler in self._before.items():
            # None: not installed from Python, which can only give the default back
            signal.signal(s, signal.SIG_DFL if handler is None else handler)

    def _note(self, number: int, _frame: object) -> None:
        """Handle a signal: remember it and announce it; a second one ends the process at once."""
        if self.signal:
            os._exit(128 + self.signal)
        self.signal = number
        if self.announce is not None:
            with suppress(RuntimeError):  # in the middle of printing something else
                self.announce()

    def poll(self) -> int:
        """Return the largest signal of any rank to stop for, 0 to go on; a deadline counts as
        SIGTERM. Collective.
        """
        late = signal.SIGTERM if self._late else 0
        return int(self.comm.max([self.signal or late])[0])

    def require_time(self) -> None:
        """Raise SceneError if any rank's deadline is over: a start-up that takes longer would never
        get further on resuming. Collective.
        """
        seconds = self.comm.max([self._late and time.monotonic() - self.begun])[0]
        if seconds:
            raise SceneError(
                f"machine.wall_seconds: found {self.deadline:g}, allowed: more than the"
                f" {seconds:.1f} s that the start-up took"
            )

    @property
    def _late(self) -> bool:
        return self.deadline is not None and time.monotonic() - self.begun > self.deadline
