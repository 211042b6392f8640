"""Corrections to the thermodynamic, fractal and continuum (TFC) limits, eq. tfc of Prodanov, Dapp &
Muser 2014:

    O_sim = O_TFC + C_t eps_t^alpha_t + C_f eps_f^alpha_f + C_c eps_c^alpha_c.

The coefficients depend on the observable, H and p_star and come from a table: the paper's, kept as
printed in data/paper_tfc.json, or a file of the same form (rows may have a "sigma" of the
coefficients).
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..util.errors import SceneError, one_line
from .checks import within

TERMS = ("t", "f", "c")
COEFFICIENTS = [f"{name}_{i}" for name in ("C", "alpha") for i in TERMS]
RATIOS = tuple(f"eps_{i}" for i in TERMS)
PRESSURE_TOLERANCE = 0.05  # how far p_star may be from a tabulated one, relative
_DATA = Path(__file__).parent / "data"
SHIPPED = {"paper": _DATA / "paper_tfc.json", "ours": _DATA / "our_tfc.json"}

Table = dict[str, Any]  # as in the data files


@dataclass(frozen=True)
class Correction:
    """The difference between a finite simulation and the TFC limit, to be subtracted.

    Attributes
    ----------
    t, f, c : float
        The three terms of eq. tfc.
    sigma : float or None
        Standard deviation of their sum by the table; None if the table has no uncertainties.
    p_star : float
        The tabulated pressure that was used.
    notes : tuple of str
        Reservations about the correction, a line each.
    """

    t: float
    f: float
    c: float
    sigma: float | None
    p_star: float
    notes: tuple[str, ...]

    @property
    def total(self) -> float:
        """The sum of the three terms."""
        return self.t + self.f + self.c

    @property
    def numbers(self) -> dict[str, float]:
        """The terms and their sum: correction_t, correction_f, correction_c, correction."""
        terms = {f"correction_{i}": getattr(self, i) for i in TERMS}
        return terms | {"correction": self.total}


def paper_table() -> Table:
    """Return the paper's tables of coefficients.

    {"tables": [{"observable": ..., "p_star": ..., "rows": [one for each Hurst exponent]}, ...]}
    """
    return table_of("paper")


def our_table() -> Table:
    """Return tables of the form of `paper_table`, fitted to our own runs, with uncertainties."""
    return table_of("ours")


def table_of(name: str) -> Table:
    """Read the table "paper" or "ours", or that of a JSON file, or raise SceneError."""
    return read_table(SHIPPED.get(name, name))


def read_table(path: str | Path) -> Table:
    """Read a table of the form of `paper_table` from a JSON file, or raise SceneError."""
    try:
        table = json.loads(Path(path).read_text(encoding="utf-8"))
        for part in table["tables"]:
            _check_part(part)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise SceneError(
            f"table: found {str(path)!r} ({one_line(str(error))}), allowed: a JSON file like"
            " paper_tfc.json"
        ) from None
    return table


def _check_part(part: Table) -> None:
    """Raise ValueError, KeyError or TypeError unless a part of a table has its form."""
    if not part["observable"].isidentifier() or not part["rows"]:
        raise ValueError("an observable without a name or without rows")
    _number(part["p_star"], positive=True)
    for row in part["rows"]:
        for name in ("hurst", *COEFFICIENTS):
            _number(row[name], positive="alpha" in name)
        for sigma in row.get("sigma", {}).values():
            _number(sigma)
        sigma_of_terms({"sigma": {}} | row, dict.fromkeys(TERMS, 0.5))


def _number(value: Any, positive: bool = False) -> None:
    """Raise ValueError unless a value of a table is a finite number (and positive)."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not np.isfinite(value) or (positive and value <= 0):
        raise ValueError(f"{value!r} is not a {'positive ' if positive else ''}number")


def correction(
    observable: str,
    hurst: float,
    p_star: float,
    eps_t: float,
    eps_f: float,
    eps_c: float,
    table: Table | None = None,
) -> Correction:
    """Compute the terms to subtract from a simulated value to get its TFC limit.

    Parameters
    ----------
    observable : str
        As the table names it: "kappa", "gap_over_h_rms", ...
    hurst : float
        Hurst exponent within the tabulated range (0.3 to 0.8 in the paper); every term is
        interpolated linearly in it.
    p_star : float
        p0/(E* g_rms), within 5 % of a tabulated pressure, whose coefficients are used as they are.
    eps_t, eps_f, eps_c : float
        lam_l/L, lam_s/lam_l and a/lam_s of the simulation, from 0 to 1.
    table : dict, optional
        A table from `paper_table` (default), `our_table` or `read_table`.

    Returns
    -------
    Correction

    Raises
    ------
    SceneError
        If the table does not cover the observable, hurst or p_star, or a ratio is out of range.
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
    """Extrapolate a simulated value to the TFC limit: subtract its `correction`.

    Parameters
    ----------
    value : float
        The simulated one.
    observable, hurst, p_star, eps_t, eps_f, eps_c, table
        As for `correction`.
    sigma : float, optional
        Standard deviation of the value.

    Returns
    -------
    extrapolated : float
    sigma : float or None
        Root of the summed squares of the sigma of the value and that of the table, as far as they
        are known; None if neither is.
    correction : Correction

    Raises
    ------
    SceneError
        As `correction`, and if value or sigma is out of range.
    """
    value = float(within("value", value, -np.inf, np.inf))
    terms = correction(observable, hurst, p_star, eps_t, eps_f, eps_c, table)
    sigmas = [within("sigma", x, 0, np.inf) for x in (sigma, terms.sigma) if x is not None]
    return value - terms.total, float(np.hypot.reduce(sigmas)) if sigmas else None, terms


def ratios(eps_t: float, eps_f: float, eps_c: float) -> dict[str, float]:
    """Return the ratios as {"t": eps_t, ...}; raise SceneError unless they are from 0 to 1."""
    by_term = zip(TERMS, (eps_t, eps_f, eps_c), strict=True)
    return {i: float(within(f"eps_{i}", value, 0, 1)) for i, value in by_term}


def term(row: Mapping[str, Any], i: str, eps: Any) -> Any:
    """Return one term of eq. tfc, C_i eps^alpha_i, by a row of a table; i is "t", "f" or "c"."""
    return row[f"C_{i}"] * eps ** row[f"alpha_{i}"]


def slopes(row: Mapping[str, Any], eps: Mapping[str, Any]) -> dict[str, Any]:
    """Return the derivatives of eq. tfc by limit, C_i and alpha_i, for the terms in eps."""
    derivatives: dict[str, Any] = {"limit": 1.0}
    for i, ratio in eps.items():
        derivatives[f"C_{i}"] = ratio ** row[f"alpha_{i}"]
        derivatives[f"alpha_{i}"] = term(row, i, ratio) * np.log(np.where(ratio > 0, ratio, 1.0))
    return derivatives


def sigma_of_terms(row: Mapping[str, Any], eps: Mapping[str, float]) -> float:
    """Return the standard deviation of the sum of terms by a row's "covariance" (in the order of
    "names"), else its "sigma"; without one a coefficient is exact.
    """
    names = row.get("names", COEFFICIENTS)
    derivatives = slopes(row, eps) | {"limit": 0.0}
    gradient = np.array([derivatives.get(name, 0.0) for name in names])
    if "covariance" in row:
        covariance = np.asarray(row["covariance"])
    else:
        covariance = np.diag([row["sigma"].get(name, 0.0) ** 2 for name in names])
    return float(np.sqrt(max(gradient @ covariance @ gradient, 0.0)))


def _part(table: Table, observable: str, p_star: float) -> Table:
    """Return the entry of a table whose p_star is nearest, within 5 %, or raise SceneError."""
    names = sorted({part["observable"] for part in table["tables"]})
    if observable not in names:
        raise SceneError(f"observable: found {observable!r}, allowed: {', '.join(names)}")
    parts = [part for part in table["tables"] if part["observable"] == observable]
    nearest: Table = min(parts, key=lambda part: abs(p_star / part["p_star"] - 1))
    if abs(p_star / nearest["p_star"] - 1) <= PRESSURE_TOLERANCE:
        return nearest
    allowed = " or ".join(f"{part['p_star']:g}" for part in parts)
    raise SceneError(
        f"p_star: found {p_star:g}, allowed: {allowed} within {PRESSURE_TOLERANCE:.0%}; "
        "the coefficients are not known in between"
    )


def _notes(table: Table, part: Table, hurst: float, tabulated: list[float]) -> Iterator[str]:
    """Yield the reservations about a correction from a part of a table, a line each."""
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
