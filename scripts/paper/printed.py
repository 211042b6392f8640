"""The numbers that the paper prints: those of its text and captions, and its coefficients."""

import json
from pathlib import Path
from typing import Any

from hpc_gfmd.theory import tfc
from hpc_gfmd.theory.tfc import term

from .rows import near

PRINTED = {"low": 0.007, "high": 0.353}  # the two values of p_star as the paper rounds them
NUMBERS = json.loads(Path(__file__).with_name("paper_numbers.json").read_text(encoding="utf-8"))


def of_hurst(name: str, hurst: float, *keys: str) -> Any:
    """Return a number of the paper for a Hurst exponent, such as of_hurst("area_high", 0.8), from
    an entry of paper_numbers.json and keys inside of it; None if the paper has none."""
    table = NUMBERS[name]
    for key in keys:
        table = table[key]
    return table.get(f"{hurst:g}")


def coefficients(observable: str, pressure: str, hurst: float) -> Any:
    """Return a row of the printed coefficient tables of kappa or gap_over_h_rms at the low or high
    pressure, {"C_c": ..., "alpha_t": ...}, or None."""
    for table in tfc.paper_table()["tables"]:
        if (table["observable"], table["p_star"]) == (observable, PRINTED[pressure]):
            return next((row for row in table["rows"] if near(row["hurst"], hurst)), None)
    return None


def correction(row: dict, eps: dict) -> float:
    """Return the sum of the three terms of eq. tfc at ratios eps with the coefficients of a row."""
    return sum(term(row, i, eps[f"eps_{i}"]) for i in "cft")


def family_label(pressure: str, hurst: float) -> str:
    """Return the name of a family of runs with the paper's numbers: "H = 0.8, p* = 0.353"."""
    return f"H = {hurst:g}, p* = {PRINTED[pressure]}"
