"""Corrections to the thermodynamic, fractal and continuum (TFC) limits, eq. tfc of Prodanov, Dapp &
Muser 2014:

    O_sim = O_TFC + C_t eps_t^alpha_t + C_f eps_f^alpha_f + C_c eps_c^alpha_c.

The coefficients depend on the observable, H and p_star and come from a table: the paper's, kept as
printed in data/paper_tfc.json, or a file of the same form (rows may have a "sigma" of the
coefficients). Fits: theory.tfc_fit.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, Field, create_model

from ..util.errors import SceneError, one_line
from .checks import within
from .tfc_fit import COEFFICIENTS, TERMS, TfcFit, fit_tfc, ratios, read_runs, sigma_of_terms, term

__all__ = [
    "TfcFit",
    "correction",
    "extrapolate",
    "fit_tfc",
    "our_table",
    "paper_table",
    "read_runs",
    "read_table",
    "table_of",
]

RATIOS = tuple(f"eps_{i}" for i in TERMS)
PRESSURE_TOLERANCE = 0.05  # how far p_star may be from a tabulated one, relative
_DATA = Path(__file__).parent / "data"
SHIPPED = {"paper": _DATA / "paper_tfc.json", "ours": _DATA / "our_tfc.json"}

Table = dict[str, Any]  # as in the data files
Finite = Annotated[float, Field(allow_inf_nan=False, strict=True)]
Positive = Annotated[Finite, Field(gt=0)]


_Row = create_model(  # type: ignore[call-overload]
    "_Row",
    hurst=(Finite, ...),
    sigma=(dict[str, Finite], {}),
    **{name: (Positive if "alpha" in name else Finite, ...) for name in COEFFICIENTS},
)


class _Part(BaseModel):
    """One observable at one pressure."""

    observable: Annotated[str, Field(pattern=r"^\w+$")]
    p_star: Positive
    rows: Annotated[list[_Row], Field(min_length=1)]  # type: ignore[valid-type]


class _Table(BaseModel):
    """What `read_table` accepts."""

    tables: list[_Part]


@dataclass(frozen=True)
class Correction:
    """What a finite simulation is off by.

    Attributes
    ----------
    t, f, c : float
        The three terms of eq. tfc.
    sigma : float or None
        The uncertainty of their sum from the table, None if it has none.
    p_star : float
        The tabulated pressure that was used.
    notes : tuple of str
        What to keep in mind, a line each.
    """

    t: float
    f: float
    c: float
    sigma: float | None
    p_star: float
    notes: tuple[str, ...]

    @property
    def total(self) -> float:
        """Add up the terms."""
        return self.t + self.f + self.c

    @property
    def numbers(self) -> dict[str, float]:
        """Return the terms and their sum, by the names of the command line."""
        terms = {f"correction_{i}": getattr(self, i) for i in TERMS}
        return terms | {"correction": self.total}


def paper_table() -> Table:
    """Return the paper's four tables, as the dict of the data file."""
    return table_of("paper")


def our_table() -> Table:
    """Return the tables of `paper_table` as fitted to our own runs, with uncertainties."""
    return table_of("ours")


def table_of(name: str) -> Table:
    """Return the table of a name: "paper", "ours", or the path of a JSON file. Raises
    SceneError."""
    return read_table(SHIPPED.get(name, name))


def read_table(path: str | Path) -> Table:
    """Read a table like that of `paper_table` from the JSON file at path. Raises SceneError if it
    is none."""
    try:
        table = json.loads(Path(path).read_text(encoding="utf-8"))
        _Table.model_validate(table)
        for row in (row for part in table["tables"] for row in part["rows"]):
            sigma_of_terms({"sigma": {}} | row, dict.fromkeys(TERMS, 0.5))
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise SceneError(
            f"table: found {str(path)!r} ({one_line(str(error))}), allowed: a JSON file like"
            " paper_tfc.json"
        ) from None
    return table


def correction(
    observable: str,
    hurst: float,
    p_star: float,
    eps_t: float,
    eps_f: float,
    eps_c: float,
    table: Table | None = None,
) -> Correction:
    """Compute the terms to subtract from a simulated value.

    Parameters
    ----------
    observable : str
        As the table names it: "kappa", "gap_over_h_rms", ...
    hurst : float
        Hurst exponent between the tabulated ones (0.3 to 0.8 in the paper); every term is linear in
        it.
    p_star : float
        p0/(E* g_rms), within 5 % of a tabulated one.
    eps_t, eps_f, eps_c : float
        lam_l/L, lam_s/lam_l and a/lam_s of the simulation, from 0 to 1.
    table : dict
        As for `paper_table` (default) or `read_table`.

    Returns
    -------
    Correction

    Raises
    ------
    SceneError
        Outside of what is tabulated.
    """
    table = table or paper_table()
    part = _part(table, observable, float(within("p_star", p_star, 0, np.inf, True)))
    eps = ratios(eps_t, eps_f, eps_c)
    rows = sorted(part["rows"], key=lambda row: row["hurst"])
    tabulated = [row["hurst"] for row in rows]
    hurst = float(within("hurst", hurst, 0, 1))
    if not tabulated[0] <= hurst <= tabulated[-1]:
        raise SceneError(
            f"hurst: found {hurst:g}, allowed: [{tabulated[0]:g}, {tabulated[-1]:g}], the range of"
            " the table (nothing justifies an extrapolation in H)"
        )
    terms = {
        i: float(np.interp(hurst, tabulated, [term(row, i, eps[i]) for row in rows])) for i in TERMS
    }
    sigma = None
    if all("sigma" in row for row in rows):
        sigma = float(np.interp(hurst, tabulated, [sigma_of_terms(row, eps) for row in rows]))
    return Correction(
        **terms,
        sigma=sigma,
        p_star=part["p_star"],
        notes=tuple(_notes(table, part, hurst, tabulated)),
    )


def extrapolate(
    value: float,
    observable: str,
    hurst: float,
    p_star: float,
    eps_t: float,
    eps_f: float,
    eps_c: float,
    sigma: float | None = None,
    table: Table | None = None,
) -> tuple[float, float | None, Correction]:
    """Take a simulated value to the TFC limit.

    Parameters
    ----------
    value : float
        The simulated one.
    observable, hurst, p_star, eps_t, eps_f, eps_c, table
        As for `correction`.
    sigma : float, optional
        Uncertainty of the value.

    Returns
    -------
    extrapolated : float
    sigma : float or None
        That of the value and that of the table in squares; None if neither is known.
    correction : Correction

    Raises
    ------
    SceneError
        As `correction`.
    """
    value = float(within("value", value, -np.inf, np.inf))
    terms = correction(observable, hurst, p_star, eps_t, eps_f, eps_c, table)
    sigmas = [within("sigma", x, 0, np.inf) for x in (sigma, terms.sigma) if x is not None]
    return value - terms.total, float(np.hypot.reduce(sigmas)) if sigmas else None, terms


def _part(table: Table, observable: str, p_star: float) -> Table:
    """Return the part of a table for an observable and a pressure. Raises SceneError where there is
    none."""
    names = sorted({part["observable"] for part in table["tables"]})
    if observable not in names:
        raise SceneError(f"observable: found {observable!r}, allowed: {', '.join(names)}")
    parts = [part for part in table["tables"] if part["observable"] == observable]
    for part in parts:
        if abs(p_star / part["p_star"] - 1) <= PRESSURE_TOLERANCE:
            return part
    allowed = " or ".join(f"{part['p_star']:g}" for part in parts)
    raise SceneError(
        f"p_star: found {p_star:g}, allowed: {allowed} within {PRESSURE_TOLERANCE:.0%}; "
        "the coefficients are not known in between"
    )


def _notes(table: Table, part: Table, hurst: float, tabulated: list[float]) -> Iterator[str]:
    """Yield what to know of an extrapolation with a part of a table, a line each."""
    if hurst not in tabulated:
        yield (
            "coefficients interpolated in H between the tabulated"
            f" {', '.join(f'{h:g}' for h in tabulated)}"
        )
    if "label" in part and part["observable"] == "gap_over_h_rms":
        yield (
            "the paper's fractal term is nearly the whole gap, because gap/h_rms vanishes in the"
            " fractal limit, and it can exceed the computed gap: take the extrapolated gap as a"
            " trend only"
        )
    if "label" in part:
        yield "the paper gives no uncertainties of its coefficients"
    if isinstance(note := table.get("note"), str) and note.isprintable():
        yield note
