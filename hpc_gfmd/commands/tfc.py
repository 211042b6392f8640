"""`hpc-gfmd tfc`: corrections to the thermodynamic, fractal and continuum limits, and fits of their
coefficients."""

from argparse import Namespace
from typing import Any

from ..theory import tfc
from ..util.errors import SceneError
from .common import as_json

GIVEN = ("hurst", "p_star", *tfc.RATIOS, "value")  # of what is to be extrapolated
# what is not given, of an extrapolation and of a fit
EXTRAPOLATION = dict.fromkeys((*GIVEN, "sigma")) | {"observable": "kappa", "table": "paper"}
FIT = {"terms": "tfc", "free": ""}


def main(args: Namespace) -> int:
    """Extrapolate a value or fit coefficients. Raises SceneError for what is missing or out of
    range."""
    unused = EXTRAPOLATION if args.fit else FIT
    given = [name for name, usual in unused.items() if getattr(args, name) != usual]
    if given:
        raise SceneError(
            f"tfc: found {_options(given)}, allowed: {'without' if args.fit else 'with'} --fit"
        )
    report, text = _fit(args) if args.fit else _extrapolate(args)
    print(as_json(report) if args.json else text)
    return 0


def _options(names: list[str]) -> str:
    """Write names of arguments as options."""
    return ", ".join(f"--{name.replace('_', '-')}" for name in names)


def _extrapolate(args: Namespace) -> Any:
    given = {name: getattr(args, name) for name in GIVEN}
    missing = [name for name, found in given.items() if found is None]
    if missing:
        raise SceneError(
            f"tfc: found no {_options(missing)}, allowed: all of them, or --fit RUNS.csv"
        )
    extrapolated, sigma, terms = tfc.extrapolate(
        observable=args.observable, sigma=args.sigma, table=tfc.table_of(args.table), **given
    )
    report = {
        "observable": args.observable,
        **given,
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
            f"  correction {i}: {getattr(terms, i):+.4f}   (eps_{i} = {given[f'eps_{i}']:g})"
            for i in "tfc"
        ),
        f"extrapolated: {extrapolated:.4f}" + ("" if sigma is None else f" +- {sigma:.4f}"),
        *(f"note: {note}" for note in terms.notes),
    ]
    return report, "\n".join(lines)


def _fit(args: Namespace) -> Any:
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
    return report, "\n".join([*lines, f"chi2 = {fit.chi2:.4g}, {fit.dof} degrees of freedom"])
