"""Units of length as scenes and instruments write them; to pint px and au are lengths, too."""

from functools import cache

_PREFIXES = {
    "": (0, ""),
    "f": (-15, "femto"),
    "p": (-12, "pico"),
    "n": (-9, "nano"),
    "u": (-6, "micro"),
    "m": (-3, "milli"),
    "c": (-2, "centi"),
    "d": (-1, "deci"),
    "k": (3, "kilo"),
}
_OTHERS = {  # in m: names, of which any may have capitals
    1e-10: ("Å", "angstrom", "angstroem", "ångström", "ångstrom", "angstroms"),
    1e-6: ("micron", "microns"),
    2.54e-5: ("mil", "mils", "thou"),
    0.0254: ("in", "inch", "inches"),
    0.3048: ("ft", "foot", "feet"),
}


@cache
def _metres_by_name() -> dict[str, float]:
    """Return the size in metres of each unit of length, by its names in lower case."""
    metres_by_name = {
        name.casefold(): metres for metres, names in _OTHERS.items() for name in names
    }
    for symbol, (power, prefix) in _PREFIXES.items():
        metres = float(f"1e{power}")
        metres_by_name[f"{symbol}m"] = metres
        for name in ("meter", "metre", "meters", "metres"):
            metres_by_name[f"{prefix}{name}"] = metres
            metres_by_name[f"{prefix}_{name}"] = metres
    return metres_by_name


def length_factor(unit: str) -> float | None:
    """Return a unit of length ("nm", "Angstrom", "NanoMeters", ...) in metres, or None; any case,
    but not the ambiguous "Mm" and "Nm".
    """
    text = unit.strip().replace("µ", "u").replace("μ", "u").replace("\u212b", "Å")
    is_symbol = len(text) <= 2 and text.isascii() and text.lower().endswith("m")
    if is_symbol and text not in (text.lower(), text.upper()):
        return None
    if text == "M":  # mega
        return None
    return _metres_by_name().get(text.casefold())
