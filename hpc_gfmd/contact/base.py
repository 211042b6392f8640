"""What is said of each number and each distribution of a load: meaning, sign, unit.

Units are products of "length", "pressure" and "force"; `util.quantities.in_units` puts in those of
a surface. "" is dimensionless.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:  # contacts need the kernels, names of observables do not
    from .contact import Contact
else:
    Contact = Any

Arrays = dict[str, np.ndarray]


@dataclass(frozen=True)
class Observable:
    """A number of a contact.

    Attributes
    ----------
    of : callable
        Of a Contact; returns None where the number has no value.
    meaning : str
        What the number is, a phrase.
    unit : str
        Product of "length", "pressure" and "force"; "" without dimension.
    sources : tuple of str
        Papers, with DOI.
    absent : str
        Why a contact may have no value, a phrase.
    """

    of: Callable[[Contact], float | None]
    meaning: str
    unit: str = ""
    sources: tuple[str, ...] = ()
    absent: str = ""

    def __call__(self, contact: Contact) -> float | None:
        return self.of(contact)


@dataclass(frozen=True)
class Distribution:
    """Arrays of a contact: a histogram, a spectrum.

    Attributes
    ----------
    of : callable
        Of a Contact: arrays by name; returns None where there is nothing to count.
    meaning : str
        What the arrays are, a phrase.
    units : dict of str to str
        Of each array, as `Observable.unit`.
    periodic : bool
        Whether it needs periodic boundaries.
    """

    of: Callable[[Contact], Arrays | None]
    meaning: str
    units: Mapping[str, str]
    periodic: bool = False

    def __call__(self, contact: Contact) -> Arrays | None:
        return self.of(contact)


ERROR = "estimated relative error of {}, the solver's on its grid"
TARGET = "what was asked for: {}"
# the other numbers that a result has of every load: meaning, unit
OF_EVERY_LOAD = {
    "p": ("mean pressure over the nominal area, positive: it pushes", "pressure"),
    "p_star": ("mean pressure over E* g_rms", ""),
    "iterations": ("iterations on the fine grid", ""),
    "fft_pairs": ("FFT pairs (forward and back), as many of the fine grid", ""),
    "wall_seconds": ("time of this load alone, without start-up", "s"),
    "status": ("converged, separated, stagnated, max_iterations, nonfinite or interrupted", ""),
    "a_r_error": (ERROR.format("a_r"), ""),
    "a_r_discretisation": ("estimated relative error of a_r by the size of a grid point", ""),
    "gap_error": (ERROR.format("gap_mean"), ""),
    "pressure_error": (ERROR.format("the pressure field (L2)"), ""),
    "precision": ("of the floating-point numbers: float32 or float64", ""),
    "residual": ("rms pressure where the gap is open, over the mean pressure", ""),
    "note": ("what limits the meaning of the numbers", ""),
    "penetration": ("largest overlap of the bodies, in units of g_rms a (a: grid spacing)", ""),
    "tension": ("largest pull where they touch, over the mean pressure", ""),
    "complementarity": ("mean of pressure times gap, over the product of their means", ""),
    "load_balance": ("relative difference of the load from the one asked for", ""),
    "certificate_precision": ("of the check of the solution: float32 or float64", ""),
    "target_gap_mean": (TARGET.format("mean gap"), "length"),
    "target_gap_over_h_rms": (TARGET.format("mean gap over h_rms"), ""),
    "target_a_r": (TARGET.format("relative contact area"), ""),
    "target_force": (TARGET.format("force"), "force"),
    "target_approach": (TARGET.format("approach"), "length"),
}
