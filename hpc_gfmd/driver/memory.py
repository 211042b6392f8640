"""What the loads so far leave behind at each point: dents, and how far a viscoelastic body has
relaxed. Each load is then an elastic contact on another wall:

Dents (a hardness): with the depth w so far, g = u + h + w, and w grows by max(-g, 0).

Relaxation, E*(t) = E* (1 - sum r + sum r exp(-t/tau)) at a constant Poisson's ratio, E* being that
at time 0. If the displacement u is linear in time over dt, then with e = exp(-dt/tau) and
f = (1 - e) tau/dt for each element (r, tau)

    k = 1 - sum r + sum r f,    c = (1/k) sum r (e q - f u_before),
    p = p0 + k K (u + c),       q <- e q + f (u - u_before)

is an elastic contact of the modulus k E* on the initial gap h - c. At dt = 0, a jump of the load, k
is 1.

The error of a load's pressure is K times that of its displacement, and so of the dents and the
relaxation that it leaves. It is the height error of the next problem, fades as the body forgets,
and counts in the certificate like rounding: iterations cannot reduce it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import exp, expm1, hypot, isfinite, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate

Element = tuple[float, float]  # share r of the modulus that relaxes, and its time tau
# Share of the accuracy for a load that others follow, over that of their pressures. Of 722 loads of
# small walls 37, 21 and 11 stagnate by an inherited error at 0.5, 0.2 and 0.05, with 16.2, 16.4 and
# 16.8 pairs.
OF_LATER = 0.05


class Maxwell:
    """Memory of a displacement, a field or a number, in a body that relaxes; it begins at 0."""

    def __init__(self, elements: Sequence[Element], u: Any):
        self.elements = elements
        self.u = u
        self.q = [u for _ in elements]

    def before(self, dt: float) -> tuple[Any, float]:
        """Return c and k of a step of dt."""
        rest = 1 - sum(r for r, _ in self.elements)
        decays = [_decay(dt, tau) for _, tau in self.elements]
        k = rest + sum(r * f for (r, _), (_, f) in zip(self.elements, decays, strict=True))
        c = sum(
            (r / k) * (e * q - f * self.u)
            for (r, _), (e, f), q in zip(self.elements, decays, self.q, strict=True)
        )
        return c, k

    def after(self, dt: float, u: Any) -> None:
        """Remember the displacement u at the end of a step of dt."""
        decays = [_decay(dt, tau) for _, tau in self.elements]
        self.q = [e * q + f * (u - self.u) for (e, f), q in zip(decays, self.q, strict=True)]
        self.u = u


def _decay(dt: float, tau: float) -> tuple[float, float]:
    x = dt / tau
    return (exp(-x), -expm1(-x) / x) if x > 0 else (1.0, 1.0)


class Memory:
    """The state of this rank's points between two loads, in the program's unit of heights.

    elements: share and time of each that relaxes; keeps_dents: with a hardness. `dents`: depths, a
    new array at each load; `body`: memory of the displacement; `position`: that of the undeformed
    body, 0 at first touch, then minus its approach, or nan.
    """

    def __init__(
        self, shape: tuple[int, ...], elements: Sequence[Element] = (), keeps_dents: bool = False
    ):
        self.dents = np.zeros(shape) if keeps_dents else None
        self.body = Maxwell(elements, np.zeros(shape) if elements else 0.0)
        self.position = Maxwell(elements, 0.0)

    def before(self, dt: float) -> np.ndarray:
        """Return by how much the initial gap has grown in a step of dt: w - c, a new array."""
        c, _ = self.body.before(dt)
        return -c if self.dents is None else self.dents - c

    def after(self, dt: float, g: np.ndarray, h: np.ndarray, position: float) -> None:
        """Remember the gap g (< 0 in new dents) after a step of dt; h: of the original wall."""
        u = np.maximum(g, 0) - h if self.body.elements else 0.0
        if self.dents is not None:
            deeper = np.negative(g, dtype=np.float64)
            np.maximum(deeper, 0, out=deeper)
            self.dents = np.add(self.dents, deeper, out=deeper)
            u = u - self.dents
        if self.body.elements:
            self.body.after(dt, u)
        self.position.after(dt, position)

    def fields(self) -> dict[str, np.ndarray]:
        """Return all fields by name, to be stored."""
        fields = {} if self.dents is None else {"dents": self.dents}
        if self.body.elements:
            fields["u"] = self.body.u
            fields |= {f"q{k}": q for k, q in enumerate(self.body.q)}
        return fields

    def restore(self, fields: Mapping[str, np.ndarray], position: Sequence[float]) -> None:
        """Take up stored fields, and the numbers of the position: u, and q of each element."""
        if self.dents is not None:
            self.dents = fields["dents"]
        if self.body.elements:
            self.body.u = fields["u"]
            self.body.q = [fields[f"q{k}"] for k in range(len(self.body.elements))]
        self.position.u, *self.position.q = position


class InheritedError:
    """Makes `Problem.height_error` from earlier certificates, the same on all ranks. Errors of
    displacements fade as the body forgets, dents keep the largest; independent, so squares are
    added.
    """

    def __init__(self, elements: Sequence[Element], keeps_dents: bool):
        self.keeps_dents = keeps_dents
        self.of_dents = 0.0
        self.of_gap = 0.0  # largest error of the mean gap, a length
        self.body = Maxwell(elements, np.zeros(0))  # a number for each load

    def before(self, dt: float) -> float:
        """Return the error of the heights in a step of dt."""
        of_loads, _ = self.body.before(dt)
        return hypot(float(np.linalg.norm(of_loads)), self.of_dents)

    def after(self, dt: float, certificate: Certificate) -> bool:
        """Remember a load's errors after a step of dt; return whether they are known."""
        inherited = self.before(dt)
        _, gap, pressure = certificate.errors
        loaded = certificate.contact > 0
        error = pressure * certificate.pressures if loaded else inherited
        if not (isfinite(error) and isfinite(gap)):
            return False
        self.of_gap = max(self.of_gap, gap * certificate.gap_mean)
        if self.keeps_dents:
            own = sqrt(max(error**2 - inherited**2, 0.0))
            self.of_dents = max(self.of_dents, own)
        if self.body.elements:
            body = self.body
            body.u, *body.q = (np.append(x, 0.0) for x in (body.u, *body.q))
            body.after(dt, np.append(np.zeros(len(body.u) - 1), error))
        return True

    def numbers(self) -> dict[str, Any]:
        """Return all that is remembered, to be stored."""
        return {
            "error_of_dents": self.of_dents,
            "error_of_gap": self.of_gap,
            "errors_of_loads": np.concatenate([self.body.u, *self.body.q]).tolist(),
        }

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Take up stored `numbers`."""
        self.of_dents, self.of_gap = numbers["error_of_dents"], numbers["error_of_gap"]
        of_loads = np.array(numbers["errors_of_loads"], float)
        self.body.u, *self.body.q = of_loads.reshape(1 + len(self.body.elements), -1)
