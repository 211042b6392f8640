"""`hpc-gfmd persson`: contact area, mean gap and stiffness of Persson's theory."""

from argparse import ArgumentParser, Namespace
from typing import Any

from ..util.errors import SceneError
from .common import add_json, as_json, number

HELP = "theory curves of Persson's contact mechanics"
DESCRIPTION = """
Relative contact area, mean gap and stiffness -dp/d(gap) of a self-affine surface. Units: stiffness
in E* g_rms/h_rms, stiffness_lam_s in E*/lam_s. Numbers may be written as 0.25, 1e-3 or 1/1024."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    parser.add_argument("--hurst", type=number, required=True, help="Hurst exponent, 0 to 1")
    parser.add_argument("--eps-f", type=number, required=True, help="lam_s/lam_l, 0 to 1")
    pressures = parser.add_mutually_exclusive_group(required=True)
    pressures.add_argument(
        "--p-star", metavar="P", nargs="+", type=number, help="pressures p0/(E* g_rms)"
    )
    pressures.add_argument(
        "--p-star-range",
        metavar=("LO", "HI", "N"),
        nargs=3,
        type=number,
        help="N pressures from LO to HI, equally spaced on a logarithmic axis",
    )
    parser.add_argument(
        "--gamma",
        type=number,
        default=0.42,
        help="energy factor of partial contact (default: %(default)s, as in the literature; 1: the"
        " original theory)",
    )
    parser.add_argument(
        "--printed",
        action="store_true",
        help="the mean gap as published in 2014, where one term lacks a factor of 2",
    )
    add_json(parser, "a table")


def main(args: Namespace) -> int:
    """Print curves of Persson's theory; returns 0. Raises SceneError for numbers out of range."""
    from pandas import DataFrame

    from ..theory import persson
    from ..theory.elastic import KAPPA_BGT

    pressures = _pressures(args)
    curve = persson.curve(pressures, args.hurst, args.eps_f, args.gamma, args.printed)
    table = DataFrame(curve)
    formula = "printed" if args.printed else "corrected"
    if args.json:
        points = table.to_dict("records")
        report = {"hurst": args.hurst, "eps_f": args.eps_f, "gamma": args.gamma, "formula": formula}
        if len(points) == 1:
            report |= points[0]
        print(as_json(report | {"points": points}))  # the stiffness is infinite at full contact
        return 0
    print(
        f"# Persson theory, H = {args.hurst:g}, eps_f = {args.eps_f:g}, gamma = {args.gamma:g},"
        f" {formula} formula; kappa at low load: {persson.KAPPA_LOW_LOAD:.4f} (Bush, Gibson,"
        f" Thomas: {KAPPA_BGT:.4f})"
    )
    print(table.to_string(index=False, float_format="{:.8g}".format, col_space=20))
    return 0


def _pressures(args: Namespace) -> Any:
    """Return the pressures p_star of the arguments, 1D. Raises SceneError if out of range."""
    import numpy as np

    from ..theory.checks import within

    if args.p_star is not None:
        return within("p_star", args.p_star, 0, np.inf, open_low=True)
    low, high, count = args.p_star_range
    within("p_star-range", [low, high], 0, np.inf, open_low=True)
    if count != int(within("p_star-range N", count, 1, 100000)):
        raise SceneError(f"p_star-range N: found {count:g}, allowed: a whole number")
    return np.geomspace(low, high, int(count))
