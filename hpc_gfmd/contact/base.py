"""Descriptions of the numbers and arrays of a load: meaning, sign, unit.

Units are products of "length", "pressure", "force" and "time"; `util.quantities.in_units` replaces
these by the units of a surface. "" is dimensionless.
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
    """A number that is computed from a Contact, and its description.

    Calling it with a Contact returns the number, or None where it has no value.

    Attributes
    ----------
    of : callable
        Function of a Contact that returns the number, or None where it has no value.
    meaning : str
        What the number is, a phrase.
    unit : str
        Product of "length", "pressure" and "force"; "" if dimensionless.
    sources : tuple of str
        Papers to cite, with DOI.
    absent : str
        Why a contact may have no value, a phrase for the user; "" if there is nothing to explain.
    """

    of: Callable[[Contact], float | None]
    meaning: str
    unit: str = ""
    sources: tuple[str, ...] = ()
    absent: str = ""

    def __call__(self, contact: Contact) -> float | None:
        """Return the number of a contact, None where it has no value."""
        return self.of(contact)


@dataclass(frozen=True)
class Distribution:
    """Arrays that are computed from a Contact, such as a histogram or spectrum, and their meaning.

    Calling it with a Contact returns {name: array}, or None if no point contributes.

    Attributes
    ----------
    of : callable
        Function of a Contact that returns {name: array}, or None if no point contributes.
    meaning : str
        What the arrays are, a phrase.
    units : dict of str to str
        Unit of each array by name, as `Observable.unit`.
    periodic : bool
        Whether it can be computed for periodic surfaces only.
    """

    of: Callable[[Contact], Arrays | None]
    meaning: str
    units: Mapping[str, str]
    periodic: bool = False

    def __call__(self, contact: Contact) -> Arrays | None:
        """Return {name: array} of a contact, None if no point contributes."""
        return self.of(contact)


ERROR = "estimated relative error of {}, the solver's on its grid"
TARGET = "what was asked for: {}"
# the other numbers that a result has of every load: meaning, unit
OF_EVERY_LOAD = {
    "p": ("mean pressure over the nominal area, positive: it pushes", "pressure"),
    "p_star": ("mean pressure over E* g_rms", ""),
    "time": ("time at which the load is reached (load.time)", "time"),
    "iterations": ("iterations on the fine grid", ""),
    "fft_pairs": ("FFT pairs (forward and back), as many of the fine grid", ""),
    "wall_seconds": ("time of this load alone, without start-up", "s"),
    "status": ("converged, separated, stagnated, max_iterations, nonfinite or interrupted", ""),
    "a_r_error": (ERROR.format("a_r"), ""),
    "a_r_discretisation": ("estimated relative error of a_r by the size of a grid point", ""),
    "gap_discretisation": ("estimated relative error of gap_mean by the size of a grid point", ""),
    "pressure_max_discretisation": (
        "estimated relative error of contact_pressure_max by the size of a grid point; inf where it"
        " has no limit on finer grids or is not known",
        "",
    ),
    "p_error": (ERROR.format("p, where adhesion holds a prescribed gap or approach"), ""),
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
