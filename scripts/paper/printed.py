"""What the paper prints: the numbers of its text and captions, and its coefficient tables."""

import json
from pathlib import Path
from typing import Any

from hpc_gfmd.theory import tfc
from hpc_gfmd.theory.tfc_fit import term

from .rows import near

PRINTED = {"low": 0.007, "high": 0.353}  # the two pressures as the paper rounds them
NUMBERS = json.loads(Path(__file__).with_name("paper_numbers.json").read_text(encoding="utf-8"))


def of_hurst(name: str, hurst: float, *keys: str) -> Any:
    """Look up what the paper gives for a Hurst exponent: of_hurst("area_high", 0.8), or None."""
    table = NUMBERS[name]
    for key in keys:
        table = table[key]
    return table.get(f"{hurst:g}")


def coefficients(observable: str, pressure: str, hurst: float) -> Any:
    """Look up the row of a printed coefficient table, {"C_c": ..., "alpha_t": ...}, or None.

    pressure: "low" or "high".
    """
    for table in tfc.paper_table()["tables"]:
        if (table["observable"], table["p_star"]) == (observable, PRINTED[pressure]):
            return next((row for row in table["rows"] if near(row["hurst"], hurst)), None)
    return None


def correction(row: dict, eps: dict) -> float:
    """Sum the three terms of eq. tfc with printed coefficients; eps: with eps_t, eps_f, eps_c."""
    return sum(term(row, i, eps[f"eps_{i}"]) for i in "cft")


def at(pressure: str, hurst: float) -> str:
    """Name a family of runs as the paper would: "H = 0.8, p* = 0.353"."""
    return f"H = {hurst:g}, p* = {PRINTED[pressure]}"
