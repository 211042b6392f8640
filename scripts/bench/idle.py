"""The time of a solve in which some threads are idle, by part.

It is measured where the package shares work out among threads: every piece of work records when it
begins and ends. In the compiled sweep over the coarse levels, where threads take pieces by
themselves, they count how often they look in vain for one.
"""

import sys
import time
from functools import wraps
from itertools import pairwise

import hpc_gfmd
from hpc_gfmd.operators.coarsest import CoarsestLevels
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel import threads as shared_out
from hpc_gfmd.solvers import solver_class

# Parts of a solve: everything outside of the iterations; an iteration; in it, the sweep over the
# coarse levels.
SET_UP = "set-up"
ITERATION = "iteration"
COARSE_LEVELS = "coarse levels"


class IdleWatch:
    """Measures from its creation on when all threads of the process work.

    Parameters
    ----------
    clock : function
        Returns the time in seconds.

    Attributes
    ----------
    threads : int
        Largest number of threads among which work has been shared out.
    """

    def __init__(self, clock=time.perf_counter):
        self.clock = clock
        self.threads = 1
        self._part = SET_UP
        self._entered = clock()
        self._clear()
        self._watch_method(solver_class("auto"), "step", ITERATION)
        self._watch_method(Multilevel, "sweep", COARSE_LEVELS)
        self._watch_pieces()
        self._watch_waits()

    def take(self):
        """Return the seconds since the last call, and start again from zero.

        Returns
        -------
        dict
            Seconds in which some thread was idle: "python" between the passes of an iteration,
            "hand_overs" while work is handed to threads in an iteration, "coarse_levels" in the
            sweep over the coarse levels, "set_up" in everything else. "all_threads": seconds in
            which all threads worked.
        """
        self._enter(self._part)
        seconds = {
            "python": self._elapsed[ITERATION] - self._shared[ITERATION],
            "hand_overs": self._shared[ITERATION] - self._full[ITERATION],
            "coarse_levels": self._elapsed[COARSE_LEVELS] - self._full[COARSE_LEVELS],
            "set_up": self._elapsed[SET_UP] - self._full[SET_UP],
            "all_threads": sum(self._full.values()),
        }
        self._clear()
        return seconds

    def _clear(self):
        parts = (SET_UP, ITERATION, COARSE_LEVELS)
        self._elapsed = dict.fromkeys(parts, 0.0)  # seconds in a part
        self._shared = dict.fromkeys(parts, 0.0)  # of these, while work is shared out
        self._full = dict.fromkeys(parts, 0.0)  # of these, while all threads work

    def _enter(self, part):
        """Enter a part of the solve and return the part that is left, after adding up its time."""
        previous_part = self._part
        time_now = self.clock()
        self._elapsed[previous_part] += time_now - self._entered
        self._entered = time_now
        self._part = part
        return previous_part

    def _watch_method(self, owner, name, part):
        method = getattr(owner, name)

        @wraps(method)
        def watched(*args, **kwargs):
            previous_part = self._enter(part)
            try:
                return method(*args, **kwargs)
            finally:
                self._enter(previous_part)

        setattr(owner, name, watched)

    def _watch_pieces(self):
        """Time every piece of work, wherever the package shares work out."""
        original = shared_out.on_threads

        def on_threads(threads, work, pieces, scratch=None):
            changes = []  # (time, +1 where a piece begins, -1 where it ends)

            def timed(*piece):
                begin = self.clock()
                try:
                    return work(*piece)
                finally:
                    changes.append((begin, 1))
                    changes.append((self.clock(), -1))

            begin = self.clock()
            try:
                return original(threads, timed, pieces, scratch)
            finally:
                self.threads = max(self.threads, threads)
                self._shared[self._part] += self.clock() - begin
                self._full[self._part] += seconds_at_work(changes, self.threads)

        for name, module in list(sys.modules.items()):
            if name.startswith(f"{hpc_gfmd.__name__}.") and hasattr(module, "on_threads"):
                module.on_threads = on_threads

    def _watch_waits(self):
        """Take the time in which threads wait within a sweep off that in which all of them work.

        Of more than two threads several wait at the same time, so that too much is taken off.
        """
        original = CoarsestLevels._do
        time_of_a_look = None

        def do(levels, begin, end):
            nonlocal time_of_a_look
            if time_of_a_look is None:
                time_of_a_look = levels.time_of_a_look(self.clock)
            original(levels, begin, end)
            waited = levels.looks * time_of_a_look
            self._full[self._part] = max(self._full[self._part] - waited, 0.0)

        CoarsestLevels._do = do


def seconds_at_work(changes, threads):
    """Return how long at least so many threads worked at the same time.

    Parameters
    ----------
    changes : list of (float, int)
        Times at which a piece of work begins (1) and ends (-1), in any order.
    threads : int
        Number of threads.

    Returns
    -------
    float
        Seconds.
    """
    seconds = 0.0
    working = 0
    for (begin, change), (end, _) in pairwise(sorted(changes)):
        working += change
        if working >= threads:
            seconds += end - begin
    return seconds
