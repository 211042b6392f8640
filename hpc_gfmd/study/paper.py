"""What the paper prints: the numbers of its text and captions, and its coefficient tables."""

import json
from functools import lru_cache
from importlib.resources import files

from ..theory import tfc
from .averages import near
from .levels import P_HIGH, P_LOW

PRINTED = {P_LOW: 0.007, P_HIGH: 0.353}  # the pressures as the paper rounds them


@lru_cache(maxsize=1)
def numbers():
    """paper_numbers.json as a dict."""
    return json.loads(files(__package__).joinpath("paper_numbers.json").read_text(encoding="utf-8"))


def coefficients(observable, p_star, hurst):
    """The row of a printed coefficient table, {"C_c": ..., "alpha_t": ...}; None where the paper has none."""
    printed = next(value for p, value in PRINTED.items() if near(p, p_star))
    for table in tfc.paper_table()["tables"]:
        if table["observable"] == observable and table["p_star"] == printed:
            return next((row for row in table["rows"] if near(row["hurst"], hurst)), None)
    return None


def of_hurst(name, hurst, *keys):
    """A number that the paper gives for a Hurst exponent, e.g. of_hurst("area_high", 0.8); None where it gives none."""
    table = numbers()[name]
    for key in keys:
        table = table[key]
    return table.get(f"{hurst:g}")


def saying(paper, ours, why=""):
    """A line of the table "paper says / we find / why"."""
    return {"paper": paper, "ours": ours, "why": why}


def quoted(value, sigma=None, digits=3):
    """A number with its uncertainty as text, "2.060(12)"-like but plainer: "2.060 +- 0.012"; "-" for None."""
    if value is None:
        return "-"
    if sigma is None or not sigma > 0:
        return f"{value:.{digits}g}"
    places = max(0, -_exponent(sigma) + 1)
    return f"{value:.{places}f} ± {sigma:.{places}f}" if places < 8 else f"{value:.{digits}g} ± {sigma:.2g}"


def _exponent(x):
    return int(f"{x:e}".rpartition("e")[2])
