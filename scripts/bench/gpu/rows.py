"""The rows that a measurement on a GPU writes, and the time of a pass."""

import json
import statistics
import sys
import time
import traceback

import cupy as cp
import numpy as np

MIB = 2**20


class Rows:
    """Writes rows of numbers to a file and to the terminal as they come.

    Attributes
    ----------
    copy_speed : float
        Bytes per second, read and written, of a copy on the device.
    is_wrong : bool
        Whether a comparison has failed.
    """

    def __init__(self, out, seconds):
        self.file = open(out, "w") if out else None  # noqa: SIM115
        self.start = time.monotonic()
        self.seconds = seconds
        self.copy_speed = float("nan")
        self.is_wrong = False

    def left(self):
        """Return the seconds that are left."""
        return self.seconds - (time.monotonic() - self.start)

    def add(self, item, **numbers):
        """Write one row."""
        numbers["at"] = round(time.monotonic() - self.start, 1)
        text = json.dumps({"item": item, **numbers})
        if self.file:
            self.file.write(text + "\n")
            self.file.flush()
        print(text, flush=True)

    def add_time(self, item, n, milliseconds, traffic, **numbers):
        """Write the time of a pass; traffic: bytes that it must move."""
        speed = traffic / milliseconds * 1e3
        numbers["ms"] = round(milliseconds, 4)
        numbers["bytes_per_point"] = round(traffic / n**2, 2)
        numbers["GB_per_s"] = round(speed / 1e9, 1)
        numbers["share_of_copy"] = round(speed / self.copy_speed, 3)
        self.add(item, n=n, **numbers)

    def add_error(self, item, **numbers):
        """Write the exception that is being handled."""
        traceback.print_exc()
        sys.stderr.flush()
        self.is_wrong = True
        error = traceback.format_exc().strip().splitlines()[-1][:300]
        self.add(item, error=error, **numbers)

    def check(self, item, value, reference, tolerance, **numbers):
        """Write a row if a value differs from its reference; return whether it is right."""
        value = np.asarray(value, np.float64)
        reference = np.asarray(reference, np.float64)
        error = float(np.linalg.norm(value - reference) / max(np.linalg.norm(reference), 1e-300))
        is_right = bool(error <= tolerance)
        self.is_wrong |= not is_right
        self.add(f"check {item}", error=error, right=is_right, **numbers)
        return is_right


def timed(work, seconds=0.25, max_repeats=15):
    """Return the median of the milliseconds that a function takes on the device."""
    start = cp.cuda.Event()
    end = cp.cuda.Event()

    def once():
        start.record()
        work()
        end.record()
        end.synchronize()
        return cp.cuda.get_elapsed_time(start, end)

    once()
    milliseconds = once()
    count = int(min(max(seconds * 1e3 / max(milliseconds, 1e-3), 3), max_repeats))
    return statistics.median(once() for _ in range(count))
