"""`hpc-gfmd persson`: contact area, mean gap and stiffness of Persson's theory."""

import json
from argparse import ArgumentParser, Namespace
from typing import Any

import numpy as np
from pandas import DataFrame

from ..theory import persson
from ..theory.checks import within
from ..theory.elastic import KAPPA_BGT
from ..util.errors import SceneError
from .common import finite, number


def add_parser(subparsers: Any) -> ArgumentParser:
    parser = subparsers.add_parser(
        "persson",
        help="theory curves of Persson's contact mechanics",
        description=(
            "Relative contact area, mean gap and stiffness -dp/d(gap) for a self-affine surface."
            " Units: stiffness in E* g_rms/h_rms, stiffness_lam_s in E*/lam_s. Numbers may be given"
            " as 0.25, 1e-3 or 1/1024."
        ),
    )
    parser.add_argument("--hurst", type=number, required=True, help="Hurst exponent, 0 to 1")
    parser.add_argument("--eps-f", type=number, required=True, help="lam_s/lam_l, 0 to 1")
    pressure = parser.add_mutually_exclusive_group(required=True)
    pressure.add_argument(
        "--p-star", type=number, nargs="+", metavar="P", help="pressures p0/(E* g_rms)"
    )
    pressure.add_argument(
        "--p-star-range",
        type=number,
        nargs=3,
        metavar=("LO", "HI", "N"),
        help="N pressures from LO to HI, equally spaced on a logarithmic axis",
    )
    parser.add_argument(
        "--gamma",
        type=number,
        default=persson.GAMMA,
        help=(
            "energy factor of partial contact (default %(default)s as in the literature; 1: first"
            " theory)"
        ),
    )
    parser.add_argument(
        "--printed",
        action="store_true",
        help="the mean gap as published in 2014, where a factor of 2 is missing in one term",
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    return parser


def main(args: Namespace) -> int:
    """Print the theory's curve. Raises SceneError for numbers out of range."""
    curve = persson.curve(_pressures(args), args.hurst, args.eps_f, args.gamma, args.printed)
    formula = "printed" if args.printed else "corrected"
    if args.json:
        points = [dict(zip(curve, point)) for point in zip(*(x.tolist() for x in curve.values()))]
        head = {"hurst": args.hurst, "eps_f": args.eps_f, "gamma": args.gamma, "formula": formula}
        shown = head | (points[0] if len(points) == 1 else {}) | {"points": points}
        print(json.dumps(finite(shown)))  # full contact makes the stiffness infinite
        return 0
    print(
        f"# Persson theory, H = {args.hurst:g}, eps_f = {args.eps_f:g}, gamma = {args.gamma:g},"
        f" {formula} formula; kappa at low load: {persson.KAPPA_LOW_LOAD:.4f} (Bush, Gibson,"
        f" Thomas: {KAPPA_BGT:.4f})"
    )
    print(DataFrame(curve).to_string(index=False, float_format="{:.8g}".format, col_space=20))
    return 0


def _pressures(args: Namespace) -> Any:
    if args.p_star is not None:
        return within("p_star", args.p_star, 0, np.inf, open_low=True)
    low, high, points = args.p_star_range
    within("p_star-range", [low, high], 0, np.inf, open_low=True)
    if points != int(within("p_star-range N", points, 1, 100000)):
        raise SceneError(f"p_star-range N: found {points:g}, allowed: a whole number")
    return np.geomspace(low, high, int(points))
