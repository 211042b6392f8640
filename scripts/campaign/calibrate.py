"""The limits of the calibrated numbers: each is moved alone until the campaign fails, and its cost
in FFT pairs is reported.

A calibrated number is a field of an instance in the package of a frozen dataclass whose name ends
with Calibration. Fields whose metadata name another measurement as `measured` are left out. A load
fails if it misses the requested accuracy or exceeds its estimate.
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

ALLOWED = 1e-3  # share of converged loads that may exceed their estimate
LARGEST_FACTOR = 8.0  # by which a number is multiplied or divided
STEPS = 4  # of the bisection up to this factor


def calibrate(args):
    """Print the smallest and the largest value of every number with which no more loads fail, and
    the mean FFT pairs with these; "-": no limit was found on these walls."""
    if args.jobs > 1:
        sys.exit(
            f"calibrate: --jobs: found {args.jobs}, allowed: 1, because numbers are changed in this"
            " process only"
        )
    where = numbers()
    base = outcome(args)
    print(f"in use: {json.dumps(base)}")
    print(f"{'number':40} {'in use':>8} {'smallest':>9} {'pairs':>6} {'largest':>9} {'pairs':>6}")
    for name in args.numbers or sorted(where):
        in_use, change = where[name]
        row = {"number": name, "in_use": in_use} | refit(args, in_use, change, base)
        cells = [f"{x:9.4g}" if x is not None else f"{'-':>9}" for x in list(row.values())[1:]]
        print(f"{name:40}{''.join(cells)}", flush=True)
        if args.out:
            with open(args.out, "a") as file:
                file.write(json.dumps(row) + "\n")


def numbers():
    """Return {name: (value in use, change)} of all calibrated numbers.

    `with change(value)` changes a number for a while.
    """
    for module in pkgutil.walk_packages(hpc_gfmd.__path__, "hpc_gfmd."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    modules = [m for name, m in sys.modules.items() if name.startswith("hpc_gfmd.")]
    calibrated = {}
    for module in modules:
        for owner in vars(module).values():
            kind = type(owner)
            if not (dataclasses.is_dataclass(kind) and kind.__name__.endswith("Calibration")):
                continue
            for field in dataclasses.fields(kind):
                if field.metadata.get("measured", "campaign") == "campaign":
                    name = f"{kind.__module__.rpartition('.')[2]}.{field.name}"
                    calibrated[name] = (
                        getattr(owner, field.name),
                        partial(_with_field, modules, owner, field.name),
                    )
    return calibrated


def _with_field(modules, owner, name, value):
    return _replaced(modules, owner, dataclasses.replace(owner, **{name: value}))


@contextmanager
def _replaced(modules, old, new):
    """Replace an object by another one under all its names in some modules."""
    places = [(m, name) for m in modules for name, value in vars(m).items() if value is old]
    for module, name in places:
        setattr(module, name, new)
    try:
        yield
    finally:
        for module, name in places:
            setattr(module, name, old)


def outcome(args):
    """Return the counts of a campaign with the present numbers."""
    return count([row for rows in campaign(args) for row in rows])


def fails(counted, base):
    """Return whether more loads fail than allowed.

    Parameters
    ----------
    counted, base : dict
        Counts with the changed number and with the numbers in use.
    """
    if counted["less_accurate"][0] > base["less_accurate"][0]:
        return True
    allowed = max(base["above_estimate"][0], ALLOWED * counted["converged"])
    return counted["above_estimate"][0] > allowed


def refit(args, in_use, change, base):
    """Return the smallest and the largest value of a number before loads fail.

    Parameters
    ----------
    args : argparse.Namespace
        Arguments of the campaign.
    in_use : float or int
        Value in use.
    change : function
        Changes the number.
    base : dict
        Counts with the value in use.

    Returns
    -------
    dict
        smallest, largest (None without a limit) and pairs_smallest, pairs_largest.
    """
    row = {}
    for end, power in (("smallest", -1), ("largest", 1)):
        good = 0.0  # exponents of LARGEST_FACTOR
        bad = None
        pairs = base["mean_pairs"]
        for step in range(STEPS + 1):
            exponent = 1.0 if step == 0 else 0.5 * (good + bad)
            value = in_use * LARGEST_FACTOR ** (power * exponent)
            with change(round(value) if isinstance(in_use, int) else value):
                counted = outcome(args)
            if fails(counted, base):
                bad = exponent
            else:
                good = exponent
                pairs = counted["mean_pairs"]
            if bad is None:
                break
        row[end] = None if bad is None else in_use * LARGEST_FACTOR ** (power * good)
        row[f"pairs_{end}"] = pairs
    return row
