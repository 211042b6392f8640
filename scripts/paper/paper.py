"""What the paper prints: the numbers of its text and captions, and its coefficient tables."""

import json
from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from typing import Any

from hpc_gfmd.theory import tfc
from hpc_gfmd.theory.tfc_fit import term

from .rows import near
from .text import filled

PRINTED = {"low": 0.007, "high": 0.353}  # the two pressures as the paper rounds them


Sayings = Iterable[dict]  # lines of the table "paper says / we find / why"


@cache
def numbers() -> dict:
    """The contents of paper_numbers.json."""
    return json.loads(files(__package__).joinpath("paper_numbers.json").read_text(encoding="utf-8"))


def of_hurst(name: str, hurst: float, *keys: str) -> Any:
    """A number that the paper gives for a Hurst exponent, e.g. of_hurst("area_high", 0.8); None
    where it gives none."""
    table = numbers()[name]
    for key in keys:
        table = table[key]
    return table.get(f"{hurst:g}")


def coefficients(observable: str, pressure: str, hurst: float) -> Any:
    """The row of a printed coefficient table, {"C_c": ..., "alpha_t": ...}; None where the paper
    has none.

    pressure: "low" or "high".
    """
    for table in tfc.paper_table()["tables"]:
        if (table["observable"], table["p_star"]) == (observable, PRINTED[pressure]):
            return next((row for row in table["rows"] if near(row["hurst"], hurst)), None)
    return None


def correction(coefficients: dict, eps_t: float, eps_f: float, eps_c: float) -> float:
    """The sum of the three terms of eq. tfc with printed coefficients."""
    return sum(term(coefficients, i, eps) for i, eps in (("c", eps_c), ("f", eps_f), ("t", eps_t)))


def at(pressure: str, hurst: float) -> str:
    """ "H = 0.8, p* = 0.353", as the paper would name a family of runs."""
    return f"H = {hurst:g}, p* = {PRINTED[pressure]}"


def saying(paper: str, ours: str, why: str = "", **row: Any) -> dict:
    """One of the Sayings, {"paper", "ours", "why"}; row: columns with which its parts are filled in
    (text.filled)."""
    return {
        name: filled(text, row) for name, text in (("paper", paper), ("ours", ours), ("why", why))
    }
