"""The time of a solve in which fewer threads work than there are, by part, measured where work is
shared out: every piece of work tells when it begins and ends."""

import sys
import time
from functools import wraps
from itertools import pairwise

import hpc_gfmd
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel import threads as shared_out
from hpc_gfmd.solvers import solver_class

# where a solve is: outside of iterations; in one; in the sweep over the coarse levels
SET_UP = "set-up"
ITERATION = "iteration"
COARSE_LEVELS = "coarse levels"


class IdleWatch:
    """Measures, from here on, when all of a process's threads work.

    Parameters
    ----------
    now : function
        A clock.

    Attributes
    ----------
    threads : int
        That work has been shared out to, at most.
    """

    def __init__(self, now=time.perf_counter):
        self.now = now
        self.threads = 1
        self._place = SET_UP
        self._entered = now()
        self._begun = self._entered
        self._clear()
        self._watch_method(solver_class("auto"), "step", ITERATION)
        self._watch_method(Multilevel, "sweep", COARSE_LEVELS)
        self._watch_pieces()

    def take(self):
        """Return what has been measured since the last time.

        Returns
        -------
        dict
            Seconds in which not all threads worked: "python" between the passes of an iteration,
            "hand_overs" of work in an iteration, "coarse_levels" in the sweep over these, "set_up"
            in all else; "all_threads": seconds in which all worked.
        """
        self._leave(self._place)
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
        places = (SET_UP, ITERATION, COARSE_LEVELS)
        self._elapsed = dict.fromkeys(places, 0.0)  # seconds in a place
        self._shared = dict.fromkeys(places, 0.0)  # of these, while work is shared out
        self._full = dict.fromkeys(places, 0.0)  # of these, while all threads work

    def _leave(self, place):
        """Book the time since the last change of place; returns the place that is left."""
        left = self._place
        time_now = self.now()
        self._elapsed[left] += time_now - self._entered
        self._entered = time_now
        self._place = place
        return left

    def _watch_method(self, owner, name, place):
        method = getattr(owner, name)

        @wraps(method)
        def watched(*args, **kwargs):
            came_from = self._leave(place)
            try:
                return method(*args, **kwargs)
            finally:
                self._leave(came_from)

        setattr(owner, name, watched)

    def _watch_pieces(self):
        """Put a stopwatch around every piece of work, wherever the package shares work out."""
        original = shared_out.on_threads

        def on_threads(threads, work, pieces, scratch=None):
            ends = []  # (time, +1 where a piece begins, -1 where it ends)

            def timed(*piece):
                begun = self.now()
                try:
                    return work(*piece)
                finally:
                    ends.append((begun, 1))
                    ends.append((self.now(), -1))

            begun = self.now()
            try:
                return original(threads, timed, pieces, scratch)
            finally:
                self.threads = max(self.threads, threads)
                self._shared[self._place] += self.now() - begun
                self._full[self._place] += seconds_at_work(ends, self.threads)

        for name, module in list(sys.modules.items()):
            if name.startswith(f"{hpc_gfmd.__name__}.") and hasattr(module, "on_threads"):
                module.on_threads = on_threads


def seconds_at_work(ends, threads):
    """Return how long so many threads worked at the same time.

    Parameters
    ----------
    ends : list of (float, int)
        Times at which a piece of work begins (1) and ends (-1), in any order.
    threads : int
        Number that is looked for, or more.

    Returns
    -------
    float
        Seconds.
    """
    seconds = 0.0
    working = 0
    for (begin, change), (end, _) in pairwise(sorted(ends)):
        working += change
        if working >= threads:
            seconds += end - begin
    return seconds
