"""What contact mechanics knows and this program does not: whoever asks for it by name is told so,
not led to the nearest key."""

import re

ONLY = "not modelled (elastic, frictionless, non-adhesive contact only)"
# beginnings of words, or of several in a row; a space at the end: the whole word
STEMS = (
    "adh",
    "cohes",
    "jkr ",
    "dmt ",
    "tabor",
    "maugis",
    "hamaker",
    "lennard",
    "van der waals",
    "surface energ",
    "surface tension",
    "interfacial",
    "capillar",
    "menisc",
    "gamma ",
    "friction",
    "coulomb",
    "cof ",
    "mu ",
    "stick ",
    "slip",
    "sliding",
    "shear",
    "tangential",
    "velocity ",
    "speed ",
    "plastic",
    "elastoplastic",
    "yield",
    "hardness",
    "hardening",
    "fracture",
    "crack",
    "fatigue",
    "visco",
    "creep",
    "relaxation time",
    "prony ",
    "loss ",
    "storage modul",
    "hystere",
    "dissipat",
    "lubric",
    "fluid",
    "oil ",
    "wear ",
    "archard",
    "temperature",
    "thermal",
    "thermo",
    "heat ",
    "pull off",
    "stiction",
    "humid",
    "electro",
)


def is_not_modelled(name: str) -> bool:
    """Whether a key or a name stands for physics that is left out; what ends in "less" does not."""
    words = re.findall("[a-z]+", re.sub("([a-z])([A-Z])", r"\1 \2", name[:200]).lower())
    text = " " + " ".join(word for word in words if not word.endswith("less")) + " "
    return any(f" {stem}" in text for stem in STEMS)
