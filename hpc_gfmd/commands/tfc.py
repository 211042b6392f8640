"""`hpc-gfmd tfc`: corrections to the thermodynamic, fractal and continuum limits."""

from argparse import ArgumentParser, Namespace

from ..util.errors import SceneError
from .common import add_json, as_json, number

REQUIRED = ("hurst", "p_star", "eps_t", "eps_f", "eps_c", "value")
HELP = "extrapolate to the thermodynamic, fractal and continuum limits"
DESCRIPTION = """
Extrapolate a simulated value with tabulated coefficients (those of the paper unless --table names
others). Numbers may be written as 0.25, 1e-3 or 1/1024."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    parser.add_argument("--observable", default="kappa", help="kappa (default) or gap_over_h_rms")
    parser.add_argument("--hurst", type=number, help="Hurst exponent of the surface")
    parser.add_argument("--p-star", type=number, help="pressure p0/(E* g_rms)")
    parser.add_argument("--eps-t", type=number, help="lam_l/L")
    parser.add_argument("--eps-f", type=number, help="lam_s/lam_l")
    parser.add_argument("--eps-c", type=number, help="a/lam_s")
    parser.add_argument("--value", type=number, help="the simulated value")
    parser.add_argument("--sigma", type=number, help="standard uncertainty of the value")
    parser.add_argument(
        "--table",
        metavar="TABLE",
        default="paper",
        help="coefficients: paper (default), ours (fitted to our own runs), or a JSON file of the"
        " same form",
    )
    add_json(parser, "text")


def main(args: Namespace) -> int:
    """Extrapolate a value and print the outcome; returns 0."""
    from ..theory import tfc
    from .limits import extrapolation_text

    values = {name: getattr(args, name) for name in REQUIRED}
    if missing := [name for name, value in values.items() if value is None]:
        options = ", ".join(f"--{name.replace('_', '-')}" for name in missing)
        raise SceneError(f"tfc: {options} missing; an extrapolation needs all of them")
    extrapolated, sigma, terms = tfc.extrapolate(
        observable=args.observable, sigma=args.sigma, table=tfc.table_of(args.table), **values
    )
    report = {
        "observable": args.observable,
        **values,
        "table": args.table,
        "table_p_star": terms.p_star,
        **terms.numbers,
        "extrapolated": extrapolated,
        "sigma": sigma,
        "notes": list(terms.notes),
    }
    text = extrapolation_text(
        args.observable, args.p_star, (args.value, args.sigma), terms.numbers, (extrapolated, sigma)
    )
    lines = [text, *(f"note: {note}" for note in terms.notes)]
    print(as_json(report) if args.json else "\n".join(lines))
    return 0
