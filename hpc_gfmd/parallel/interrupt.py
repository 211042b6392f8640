"""Requests to stop: signals and the wall-clock budget, agreed on by all ranks."""

import os
import signal
import time

CHEAP = 0.05  # share of the time that may go into checkpoints between loads
HANDLED = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)  # SIGUSR1: the batch system's warning


class Interrupt:
    """Listens from `with` on. deadline: seconds from now, or None; every: seconds between checkpoints.

    A second signal ends the process at once.
    """

    def __init__(self, comm, deadline=None, every=None):
        self.comm = comm
        self.begun = time.monotonic()
        self.deadline, self.every = deadline, every
        self.last, self.cost = self.begun, 0.0  # end of the last checkpoint, and what it took
        self.signal = 0
        self.agreed = 0

    def __enter__(self):
        self._before = {}
        try:
            self._before = {s: signal.signal(s, self._note) for s in HANDLED}
        except ValueError:  # not in the main thread: somebody else handles signals
            pass
        return self

    def __exit__(self, *_):
        for s, handler in self._before.items():
            signal.signal(s, handler)

    def _note(self, number, _frame):
        if self.signal:
            os._exit(128 + self.signal)
        self.signal = number

    @property
    def exit_code(self):
        """130 for SIGINT, 143 for everything else that stopped the run."""
        return 130 if self.agreed == signal.SIGINT else 143

    def poll(self):
        """(stop, save), the same on all ranks: whether to stop now, and whether a checkpoint is due. Collective."""
        now = time.monotonic()
        stop = self.signal
        if not stop and self.deadline is not None and now - self.begun > self.deadline:
            stop = signal.SIGTERM
        due = self.every is not None and self.comm.rank == 0 and now - self.last > self.every
        stop, due = (int(x) for x in self.comm.max([stop, due]))
        if stop:
            self.agreed = stop
        return bool(stop), bool(due)

    def cheap(self):
        """Whether a checkpoint now would take little beside the time since the last one, the same on all ranks. Collective."""
        return bool(self.comm.max([self.comm.rank == 0 and self.cost < CHEAP * (time.monotonic() - self.last)])[0])

    def saved(self, begun):
        """A checkpoint has been written; it was begun at that time.monotonic()."""
        self.last = time.monotonic()
        self.cost = self.last - begun
