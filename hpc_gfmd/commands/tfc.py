"""`hpc-gfmd tfc`: corrections to the thermodynamic, fractal and continuum limits; fits of them."""

from argparse import ArgumentParser, Namespace
from typing import Any

from ..util.errors import SceneError
from .common import add_file, add_json, as_json, number

RATIOS = ("eps_t", "eps_f", "eps_c")
REQUIRED = ("hurst", "p_star", *RATIOS, "value")  # of an extrapolation
# options of an extrapolation alone and of a fit alone, with their defaults
EXTRAPOLATION = dict.fromkeys((*REQUIRED, "sigma")) | {"observable": "kappa", "table": "paper"}
FIT = {"terms": "tfc", "free": ""}
HELP = "extrapolate to the thermodynamic, fractal and continuum limits"
DESCRIPTION = """
Extrapolate a simulated value with tabulated coefficients (those of the paper unless --table names
others), or fit the coefficients to the runs in a CSV file. Numbers may be written as 0.25, 1e-3 or
1/1024."""


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
    add_file(
        parser,
        "--fit",
        metavar="RUNS.csv",
        help="fit the coefficients to the columns eps_t, eps_f, eps_c, value[, sigma]",
    )
    parser.add_argument(
        "--terms", default="tfc", help="terms to fit, any of t, f, c (default: %(default)s)"
    )
    parser.add_argument(
        "--free",
        metavar="TERMS",
        default="",
        help="terms whose exponent is fitted, too (default: none)",
    )
    add_json(parser, "text")


def main(args: Namespace) -> int:
    """Extrapolate a value, or fit coefficients to runs, and print the outcome; returns 0.

    Raises SceneError if arguments are missing, out of range or do not go together.
    """
    not_allowed = EXTRAPOLATION if args.fit else FIT
    unused = [name for name, default in not_allowed.items() if getattr(args, name) != default]
    if unused:
        raise SceneError(
            f"tfc: found {_options(unused)}, allowed: {'without' if args.fit else 'with'} --fit"
        )
    report, text = _fit(args) if args.fit else _extrapolate(args)
    print(as_json(report) if args.json else text)
    return 0


def _options(names: list[str]) -> str:
    """Return names of arguments as options: "--p-star, --eps-t"."""
    return ", ".join(f"--{name.replace('_', '-')}" for name in names)


def _extrapolate(args: Namespace) -> tuple[dict[str, Any], str]:
    """Return an extrapolation as a dict for JSON and as text.

    Raises SceneError if an argument is missing or out of range, or the table cannot be read.
    """
    from ..theory import tfc

    values = {name: getattr(args, name) for name in REQUIRED}
    missing = [name for name, value in values.items() if value is None]
    if missing:
        raise SceneError(
            f"tfc: found no {_options(missing)}, allowed: all of them, or --fit RUNS.csv"
        )
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
    lines = [
        f"{args.observable} = {args.value:g} at H = {args.hurst:g}, p_star = {args.p_star:g}",
        *(
            f"  correction {i}: {getattr(terms, i):+.4f}   (eps_{i} = {values[f'eps_{i}']:g})"
            for i in "tfc"
        ),
        f"extrapolated: {extrapolated:.4f}" + ("" if sigma is None else f" +- {sigma:.4f}"),
        *(f"note: {note}" for note in terms.notes),
    ]
    return report, "\n".join(lines)


def _fit(args: Namespace) -> tuple[dict[str, Any], str]:
    """Fit coefficients to the runs in args.fit; returns a dict for JSON, and text.

    Raises SceneError if the file cannot be read or the runs do not determine the coefficients.
    """
    from ..theory import tfc

    if set(args.free) - set(args.terms):
        raise SceneError(
            f"free: found {args.free!r}, allowed: letters of the fitted terms, {args.terms}"
        )
    fit = tfc.fit_tfc(
        **tfc.read_runs(args.fit), alpha=dict.fromkeys(args.free), terms=tuple(args.terms)
    )
    numbers = {
        "limit": fit.limit,
        **{f"C_{i}": c for i, c in fit.C.items()},
        **{f"alpha_{i}": a for i, a in fit.alpha.items()},
    }
    report = numbers | {"sigma": fit.sigma, "chi2": fit.chi2, "dof": fit.dof}
    lines = [
        f"{name:>8} = {x:.5g} " + (f"+- {fit.sigma[name]:.2g}" if name in fit.sigma else "(fixed)")
        for name, x in numbers.items()
    ]
    lines.append(f"chi2 = {fit.chi2:.4g}, {fit.dof} degrees of freedom")
    return report, "\n".join(lines)
