"""Physics that is not modelled: keys named after it get a message instead of a similar key."""

import re

ONLY = "not modelled (frictionless contact under a normal load only)"
# beginnings of words, or of several in a row; \b: the whole word
STEMS = (
    r"surface tension|interfacial|capillar|menisc|friction|coulomb|cof\b|mu\b|stick\b"
    r"|slip|sliding|shear|tangential|velocity\b|speed\b|plasticity|elasto ?plastic|yield"
    r"|hardening|fracture|crack|fatigue|viscosity|lubric|fluid|oil\b|wear\b|archard|stiction|humid"
)
ADHESION = (
    r"adh|cohes|jkr\b|dmt\b|tabor|maugis|hamaker|lennard|van der waals|surface energ"
    r"|gamma\b|pull off"
)
KEY = "adhesion"  # a valid key
ATTRACTION = "unknown key; material.adhesion = {work, range, law} is the attraction of the surfaces"
VISCOELASTIC = r"visco|creep|relaxation time|prony\b|loss\b|storage modul|maxwell"
WITH_TIME = "unknown key; material.relaxation with load.time is a solid that relaxes"
CONDUCTION = r"temperature|therm|heat\b|current\b|electr|voltage|conductivit|resistiv|resistance"
INSTEAD = f'{ONLY}; output.observables = ["conductance"] is the conductance of the contact'
OTHERS = ((VISCOELASTIC, WITH_TIME), (CONDUCTION, INSTEAD))


def not_modelled(*names: str) -> str:
    """Return a message, "" if none, on the first name, a key or value of any spelling ("gammaSL"),
    for physics without a key; words in "less" ("frictionless") pass.
    """
    for name in names:
        if name == KEY:
            continue
        words = re.findall("[a-z]+", re.sub("([a-z])([A-Z])", r"\1 \2", name[:200]).lower())
        text = " ".join(word for word in words if not word.endswith("less"))
        for stems, message in ((STEMS, ONLY), (ADHESION, ATTRACTION), *OTHERS):
            if re.search(rf"\b(?:{stems})", text):
                return message
    return ""
