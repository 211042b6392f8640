"""Attributes of groups: numbers, texts, and lists of them.

HDF5 keeps texts of any length, which other programs expect, where it has no checksums and where a flipped bit may crash it. So all
texts stand once more in one line of JSON of fixed length, which the checksums cover, and we read them from nowhere else.
"""

import json

import numpy as np

RECORD = "record"


def set_attributes(group, attributes: dict) -> None:
    """Write all that are not None; a dict as JSON."""
    found = {name: json.dumps(value) if isinstance(value, dict) else value for name, value in attributes.items() if value is not None}
    group.attrs.update(found)
    group.attrs[RECORD] = np.bytes_(json.dumps({name: value if np.asarray(value).dtype.kind == "U" else None
                                                for name, value in found.items()}))


def attributes_of(group) -> dict:
    """As Python numbers, texts and lists, in the order in which they were written."""
    texts = json.loads(group.attrs[RECORD])
    return {name: group.attrs[name].tolist() if text is None else text for name, text in texts.items()}
