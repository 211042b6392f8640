"""What contact mechanics knows and this program does not: whoever asks for it by name is told so,
not led to the nearest key."""

import re

ONLY = "not modelled (elastic, frictionless, non-adhesive contact only)"
# beginnings of words, or of several in a row; \b: the whole word
STEMS = (
    r"adh|cohes|jkr\b|dmt\b|tabor|maugis|hamaker|lennard|van der waals|surface energ"
    r"|surface tension|interfacial|capillar|menisc|gamma\b|friction|coulomb|cof\b|mu\b|stick\b"
    r"|slip|sliding|shear|tangential|velocity\b|speed\b|plasticity|elasto ?plastic|yield"
    r"|hardening|fracture|crack|fatigue|visco|creep|relaxation time|prony\b|loss\b|storage modul"
    r"|hystere|dissipat|lubric|fluid|oil\b|wear\b|archard|pull off|stiction|humid"
)
CONDUCTION = r"temperature|therm|heat\b|current\b|electr|voltage|conductivit|resistiv|resistance"
INSTEAD = f'{ONLY}; output.observables = ["conductance"] is the conductance of the contact'


def not_modelled(*names: str) -> str:
    """Return what is said of keys or names where one stands for physics that is left out, else "".

    A word that ends in "less" stands for none.
    """
    for name in names:
        words = re.findall("[a-z]+", re.sub("([a-z])([A-Z])", r"\1 \2", name[:200]).lower())
        text = " ".join(word for word in words if not word.endswith("less"))
        for stems, said in ((STEMS, ONLY), (CONDUCTION, INSTEAD)):
            if re.search(rf"\b(?:{stems})", text):
                return said
    return ""
