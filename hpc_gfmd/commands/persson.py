"""`hpc-gfmd persson`: contact area, mean gap and stiffness of Persson's theory."""

from argparse import Namespace
from typing import Any

import numpy as np
from pandas import DataFrame

from ..theory import persson
from ..theory.checks import within
from ..theory.elastic import KAPPA_BGT
from ..util.errors import SceneError
from .common import as_json


def main(args: Namespace) -> int:
    """Print the theory's curve. Raises SceneError for numbers out of range."""
    curve = persson.curve(_pressures(args), args.hurst, args.eps_f, args.gamma, args.printed)
    table = DataFrame(curve)
    formula = "printed" if args.printed else "corrected"
    if args.json:
        points = table.to_dict("records")
        head = {"hurst": args.hurst, "eps_f": args.eps_f, "gamma": args.gamma, "formula": formula}
        shown = head | (points[0] if len(points) == 1 else {}) | {"points": points}
        print(as_json(shown))  # full contact makes the stiffness infinite
        return 0
    print(
        f"# Persson theory, H = {args.hurst:g}, eps_f = {args.eps_f:g}, gamma = {args.gamma:g},"
        f" {formula} formula; kappa at low load: {persson.KAPPA_LOW_LOAD:.4f} (Bush, Gibson,"
        f" Thomas: {KAPPA_BGT:.4f})"
    )
    print(table.to_string(index=False, float_format="{:.8g}".format, col_space=20))
    return 0


def _pressures(args: Namespace) -> Any:
    if args.p_star is not None:
        return within("p_star", args.p_star, 0, np.inf, open_low=True)
    low, high, points = args.p_star_range
    within("p_star-range", [low, high], 0, np.inf, open_low=True)
    if points != int(within("p_star-range N", points, 1, 100000)):
        raise SceneError(f"p_star-range N: found {points:g}, allowed: a whole number")
    return np.geomspace(low, high, int(points))
