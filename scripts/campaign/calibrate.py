"""What the calibrated numbers have to be: each is moved alone until the campaign fails, and what it
costs in FFT pairs is said.

A number is a field of a frozen dataclass whose name ends with Calibration, of which the package
has an instance; a field whose metadata says that something else than the campaign `measured` it is
left alone.
A load fails if it is less accurate than asked or above its own estimate.
"""

import dataclasses
import importlib
import json
import pkgutil
import sys
from contextlib import contextmanager
from functools import partial

import hpc_gfmd

from .run import campaign
from .table import count

ALLOWED = 1e-3  # share of the converged loads above their own estimate
FURTHEST = 8.0  # times the number, or over it, that is tried
STEPS = 4  # of the bisection between


def calibrate(given):
    """Print every number in use beside the smallest and the largest with which no more loads fail,
    and the mean FFT pairs with these; `-`: no wall of `given` asks for more."""
    if given.jobs > 1:
        sys.exit(
            f"calibrate: --jobs: found {given.jobs}, allowed: 1, as other processes know no moves"
        )
    where = numbers()
    base = outcome(given)
    print(f"in use: {json.dumps(base)}")
    print(f"{'number':40} {'in use':>8} {'smallest':>9} {'pairs':>6} {'largest':>9} {'pairs':>6}")
    for name in given.numbers or sorted(where):
        in_use, change = where[name]
        row = {"number": name, "in_use": in_use} | refit(given, in_use, change, base)
        cells = [f"{x:9.4g}" if x is not None else f"{'-':>9}" for x in list(row.values())[1:]]
        print(f"{name:40}{''.join(cells)}", flush=True)
        if given.out:
            with open(given.out, "a") as file:
                file.write(json.dumps(row) + "\n")


def numbers():
    """Find {name: (value in use, change)} of all calibrated numbers; `with change(value)` moves
    one."""
    for module in pkgutil.walk_packages(hpc_gfmd.__path__, "hpc_gfmd."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    modules = [m for name, m in sys.modules.items() if name.startswith("hpc_gfmd.")]
    found = {}
    for module in modules:
        for owner in vars(module).values():
            kind = type(owner)
            if not (dataclasses.is_dataclass(kind) and kind.__name__.endswith("Calibration")):
                continue
            for field in dataclasses.fields(kind):
                if field.metadata.get("measured", "campaign") == "campaign":
                    name = f"{kind.__module__.rpartition('.')[2]}.{field.name}"
                    found[name] = (
                        getattr(owner, field.name),
                        partial(_with_field, modules, owner, field.name),
                    )
    return found


def _with_field(modules, owner, name, value):
    return _replaced(modules, owner, dataclasses.replace(owner, **{name: value}))


@contextmanager
def _replaced(modules, old, new):
    """Let every name in these modules that means one thing mean another."""
    places = [(m, name) for m in modules for name, value in vars(m).items() if value is old]
    for module, name in places:
        setattr(module, name, new)
    try:
        yield
    finally:
        for module, name in places:
            setattr(module, name, old)


def outcome(given):
    """Count what comes of the campaign as the numbers are."""
    return count([row for new in campaign(given) for row in new])


def fails(found, base):
    """Tell whether more loads are wrong than are allowed, beyond those that are so with the numbers
    in use."""
    most = max(base["above_estimate"][0], ALLOWED * found["converged"])
    return found["less_accurate"][0] > base["less_accurate"][0] or found["above_estimate"][0] > most


def refit(given, in_use, change, base):
    """Find how far a number may go either way before loads fail, by bisection of factors."""
    row = {}
    for what, power in (("smallest", -1), ("largest", 1)):
        good, bad, pairs = 0.0, None, base["mean_pairs"]
        for step in range(STEPS + 1):
            tried = 1.0 if step == 0 else 0.5 * (good + bad)
            value = in_use * FURTHEST ** (power * tried)
            with change(round(value) if isinstance(in_use, int) else value):
                found = outcome(given)
            if fails(found, base):
                bad = tried
            else:
                good, pairs = tried, found["mean_pairs"]
            if bad is None:
                break
        row[what] = None if bad is None else in_use * FURTHEST ** (power * good)
        row[f"pairs_{what}"] = pairs
    return row
