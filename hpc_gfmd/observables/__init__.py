"""One idea per file: OBSERVABLES = {name: function(contact) -> number or None}. None is left out of
the result.

ON_REQUEST = True marks a file whose observables take FFT pairs or passes over the fields of their
own: only where the scene names them. TOGETHER = {name: names of observables} has names that stand
for several. DISTRIBUTIONS = {name: function(contact) -> {what: array of numbers} or None}, always
on request, becomes the attributes NAME_WHAT of a load step; PERIODIC = True: not for surfaces that
end.

`contact` is a contact.Contact; sums that several observables share are its cached properties, so
that what nobody asks for is not computed. Numbers are in the scene's units.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:  # contacts need the kernels, names of observables do not
    from ..contact import Contact

    Observable = Callable[[Contact], float | None]
    Distribution = dict[str, np.ndarray]
    Counted = Callable[[Contact], Distribution | None]
