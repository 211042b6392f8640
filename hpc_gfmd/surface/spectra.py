"""Power spectra of isotropic surfaces, as tables between whose rows they are power laws."""

from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ..util.atomic import atomic_write
from ..util.errors import SceneError
from ..util.quantities import factor, finite_number, prefixed
from .statistics import Roughness

NO_UNIT = "length"  # in place of a unit in the head of a table


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The power spectrum of an isotropic surface, averaged over directions.

    Between two rows C is a power law; beyond the first and the last it is 0.

    Attributes
    ----------
    q : ndarray
        Wave numbers 2 pi/lambda, rising, in 1/unit.
    C : ndarray
        Power spectrum, positive, in unit^4: h_rms^2 = (1/2 pi) times the integral of C q dq, and
        C(q) = L_x L_y <|h_q|^2> on a cell L_x x L_y.
    unit : str
        "m", or "" without a unit.
    notes : tuple of str
        What was done to it, a line each.
    """

    q: np.ndarray
    C: np.ndarray
    unit: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require_rows(self.q, self.C)

    @property
    def exponents(self) -> np.ndarray:
        """Exponent e of C ~ q^-e between each two rows."""
        return -np.diff(np.log(self.C)) / np.diff(np.log(self.q))

    @property
    def hurst(self) -> np.ndarray:
        """Hurst exponent H of C ~ q^(-2 - 2 H) between each two rows."""
        return self.exponents / 2 - 1

    def at(self, q: ArrayLike) -> np.ndarray:
        """Return C at some q; 0 beyond the rows."""
        q = np.asarray(q, float)
        inside = (q >= self.q[0]) & (q <= self.q[-1])
        with np.errstate(divide="ignore"):
            C = np.exp(np.interp(np.log(q), np.log(self.q), np.log(self.C)))
        return np.where(inside, C, 0.0)

    def write(self, path: str | PathLike) -> None:
        """Write it as a table that kind = "spectrum" reads: columns q and C, units in the head.

        Parameters
        ----------
        path
            A file, such as "spectrum.csv"; an older one is replaced.
        """
        unit = self.unit or NO_UNIT
        rows = zip(self.q.tolist(), self.C.tolist())
        lines = [
            *(f"# {note}" for note in self.notes),
            f"q (1/{unit}),C ({unit}^4)",
            *(f"{q!r},{C!r}" for q, C in rows),
        ]
        with atomic_write(Path(path)) as tmp:
            tmp.write_text("\n".join(lines) + "\n", encoding="utf-8")

    def between(self, lowest: float, highest: float) -> Self:
        """Return a copy without the waves below and above some q.

        Parameters
        ----------
        lowest, highest : float
            Wave numbers, 0 and inf for all.

        Returns
        -------
        Spectrum

        Raises
        ------
        SceneError
            If there are none between them.
        """
        low = max(lowest, self.q[0])
        high = min(highest, self.q[-1])
        if not low < high:
            raise SceneError(
                f"surface: found a spectrum from q = {self.q[0]:.6g} to {self.q[-1]:.6g} and waves"
                f" from {lowest:.6g} to {highest:.6g}, allowed: some of the spectrum"
            )
        inside = (self.q > low) & (self.q < high)
        q = np.array([low, *self.q[inside], high])
        ends = self.at([low, high])
        return type(self)(q, np.array([ends[0], *self.C[inside], ends[1]]), self.unit)

    def extended(self, shortest: float, over: float = 3.0) -> Self:
        """Return a copy that goes on to shorter waves with the exponent of its own end.

        Parameters
        ----------
        shortest : float
            Wavelength at which it ends, in `unit`.
        over : float
            The exponent is that of the power law that fits C best between the last q and this part
            of it, each octave with equal weight.

        Returns
        -------
        Spectrum
            Its last note has the Hurst exponent and the share of g_rms^2 that is extended.

        Raises
        ------
        SceneError
            If it reaches these waves already, and for numbers out of range.
        """
        end = float(self.q[-1])
        longest = 2 * np.pi / end
        if not 0 < finite_number(shortest) < longest:
            raise SceneError(
                f"shortest: found {shortest!s}, allowed: a number below {longest:.6g}, where the"
                " spectrum ends"
            )
        if not finite_number(over) > 1:
            raise SceneError(f"over: found {over!s}, allowed: a number greater than 1")
        q_new = 2 * np.pi / shortest
        q = np.geomspace(max(end / over, self.q[0]), end, 33)
        slope, level = np.polyfit(np.log(q / end), np.log(self.at(q)), 1)
        ends = np.exp(level + slope * np.log([1.0, q_new / end]))
        extended = type(self)(np.append(self.q, q_new), np.append(self.C[:-1], ends), self.unit)
        share = 1 - (self.roughness().g_rms / extended.roughness().g_rms) ** 2
        note = (
            f"extended from {self._length(2 * np.pi / end)} to {self._length(shortest)} with H ="
            f" {-slope / 2 - 1:.3g}: {100 * share:.0f} % of g_rms^2"
        )
        return replace(extended, notes=(*self.notes, note))

    def _length(self, length: float) -> str:
        size, name = prefixed([length], self.unit)
        return f"{length / size:.4g} {name}".strip()

    def __repr__(self) -> str:
        longest, shortest = (self._length(2 * np.pi / q) for q in (self.q[0], self.q[-1]))
        roughness = self.roughness()
        parts = [
            f"{len(self.q)} rows",
            f"waves from {longest} to {shortest}",
            f"h_rms = {self._length(roughness.h_rms)}",
            f"g_rms = {roughness.g_rms:.4g}",
            *self.notes,
        ]
        return f"<spectrum: {', '.join(parts)}>"

    def roughness(self) -> Roughness:
        """Return h_rms, g_rms and rms curvature (half of the Laplacian)."""
        moments = [self._moment(power) for power in (0, 2, 4)]
        h_rms, g_rms, laplacian = np.sqrt(moments).tolist()
        return Roughness(h_rms, g_rms, laplacian / 2)

    def _moment(self, power: int) -> float:
        m = 2 + power - self.exponents
        ratio = np.diff(np.log(self.q))
        x = m * ratio
        with np.errstate(over="ignore"):
            mean = np.where(x == 0, 1.0, np.expm1(x) / np.where(x == 0, 1.0, x))
        return float(np.sum(self.C[:-1] * self.q[:-1] ** (2 + power) * ratio * mean) / (2 * np.pi))


def in_metres(q: np.ndarray, C: np.ndarray, dimension: int, unit: str) -> Spectrum:
    """Return the spectrum of a table, in m if it has a unit; dimension 1: C of profiles."""
    size = factor(unit) if unit else 1.0
    return Spectrum(q / size, C * size ** (2 + dimension), "m" if unit else "")


def require_rows(q: np.ndarray, C: np.ndarray, where: str = "surface", of: str = "") -> None:
    """Raise SceneError unless q rise, all numbers are positive, and there are at least two rows."""
    if len(q) < 2:
        raise SceneError(f"{where}: found {len(q)} rows{of}, allowed: at least two, of q and C")
    for name, values in (("q", q), ("C", C)):
        wrong = ~(np.isfinite(values) & (values > 0))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise SceneError(
                f"{where}: found {name} = {values[row]:.6g} in row {row + 1}{of}, allowed: positive"
                " numbers"
            )
    falls = np.diff(q) <= 0
    if falls.any():
        row = int(np.argmax(falls))
        raise SceneError(
            f"{where}: found q = {q[row]:.6g} and then {q[row + 1]:.6g} in row {row + 2}{of},"
            " allowed: rising q"
        )


def of_isotropic_surface(profiles: Spectrum) -> Spectrum:
    """Return the spectrum of the isotropic surface whose profiles have C1 (h_rms^2 = (1/pi) int C1
    dq).

    C(q) = -2 int_q^inf dC1/dq' / sqrt(q'^2 - q^2) dq' (Jacobs, Junge & Pastewka 2017), with the
    last power law beyond the last row. SceneError if C1 rises, or does not fall at its end.
    """
    from scipy.special import beta, betainc

    exponents = np.append(profiles.exponents, profiles.exponents[-1])
    rises = exponents < 0
    if rises.any():
        row = int(np.argmax(rises))
        raise SceneError(
            "surface: found a spectrum of profiles that rises between q ="
            f" {profiles.q[row]:.6g} and {profiles.q[row + 1]:.6g}, allowed: one that falls, as of"
            " all isotropic surfaces; surface.longest, surface.shortest leave waves out"
        )
    if exponents[-1] == 0:
        raise SceneError(
            "surface: found a spectrum of profiles that is constant at its end, allowed: one that"
            " falls there; surface.shortest leaves waves out"
        )
    begins = profiles.q
    ends = np.append(profiles.q[1:], np.inf)
    a = (exponents + 1) / 2
    C = np.empty(len(begins))
    for row, q in enumerate(begins):
        x_begin = np.minimum((q / begins[row:]) ** 2, 1.0)
        x_end = (q / ends[row:]) ** 2
        part = beta(a[row:], 0.5) * (betainc(a[row:], 0.5, x_begin) - betainc(a[row:], 0.5, x_end))
        with np.errstate(over="ignore", invalid="ignore"):
            terms = (
                exponents[row:] * profiles.C[row:] * (begins[row:] / q) ** exponents[row:] * part
            )
        C[row] = np.sum(terms[part > 0]) / q
    return Spectrum(profiles.q, C, profiles.unit)
