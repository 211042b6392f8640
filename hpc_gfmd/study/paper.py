"""What the paper prints: the numbers of its text and captions, and its coefficient tables."""

import json
from functools import cache
from importlib.resources import files
from typing import Any

from ..theory import tfc
from .rows import near

PRINTED = {"low": 0.007, "high": 0.353}  # the two pressures as the paper rounds them


@cache
def numbers() -> dict:
    """The contents of paper_numbers.json."""
    return json.loads(files(__package__).joinpath("paper_numbers.json").read_text(encoding="utf-8"))


def of_hurst(name: str, hurst: float, *keys: str) -> Any:
    """A number that the paper gives for a Hurst exponent, e.g. of_hurst("area_high", 0.8); None where it gives none."""
    table = numbers()[name]
    for key in keys:
        table = table[key]
    return table.get(f"{hurst:g}")


def coefficients(observable: str, pressure: str, hurst: float) -> Any:
    """The row of a printed coefficient table, {"C_c": ..., "alpha_t": ...}; None where the paper has none.

    pressure: "low" or "high".
    """
    for table in tfc.paper_table()["tables"]:
        if (table["observable"], table["p_star"]) == (observable, PRINTED[pressure]):
            return next((row for row in table["rows"] if near(row["hurst"], hurst)), None)
    return None


def correction(coefficients: dict, eps_t: float, eps_f: float, eps_c: float) -> float:
    """The sum of the three terms of eq. tfc with printed coefficients."""
    eps = {"c": eps_c, "f": eps_f, "t": eps_t}
    return sum(coefficients[f"C_{i}"] * eps[i] ** coefficients[f"alpha_{i}"] for i in eps)


def saying(paper: str, ours: str, why: str = "") -> dict:
    """A line of the table "paper says / we find / why"."""
    return {"paper": paper, "ours": ours, "why": why}


def quoted(value: Any, sigma: float | None = None, digits: int = 3) -> str:
    """A number with its uncertainty in two digits, "2.060 ± 0.012"; "-" for None."""
    if value is None:
        return "-"
    if sigma is None or not sigma > 0:
        return f"{value:.{digits}g}"
    places = max(0, 1 - int(f"{sigma:e}".rpartition("e")[2]))
    return f"{value:.{places}f} ± {sigma:.{places}f}" if places < 8 else f"{value:.{digits}g} ± {sigma:.2g}"
