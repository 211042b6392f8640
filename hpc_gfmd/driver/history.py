"""Loads that follow from each other: bodies that relax, dents that stay.

What the loads before have left (memory.py) changes the initial gap and the modulus; with these a
load is an elastic contact like any other. The errors of earlier loads make the changed gap
uncertain, and count towards the errors of later ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from .memory import OF_LATER, InheritedError, Memory
from .precision import DOUBLE
from .sweep import Sweep
from .without_iterations import unloaded_contact

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..scene import LoadTable
    from ..surface import Surface
    from .drive import Watch
    from .grid_errors import CoarseContact
    from .load import Load, Unfinished
    from .memory import Element

FINEST = 1e-8  # finest accuracy that is asked of a step for the sake of later ones
OF_SEARCHED = 0.02  # as OF_LATER, where pressures are not known before


def _shares(loads: Sequence[Load]) -> list[float]:
    """Return the share of the accuracy for each load: the wall keeps absolute errors, relatively
    larger at lighter loads.
    """
    if not loads[0].is_pressure:
        return [OF_SEARCHED] * (len(loads) - 1) + [1.0]
    shares = [1.0]
    lightest = inf
    for later, load in pairwise(reversed(loads)):
        lightest = min(lightest, later.value or inf)
        shares.append(OF_LATER * min(1.0, lightest / load.value) if load.value else 1.0)
    return shares[::-1]


class History:
    """Solves loads on a wall that earlier loads have changed; takes the place of a Sweep.

    Each load has a new Sweep, with the surface, model and settings of `sweep` but for what has
    changed. elements: (share, time) of each part of the modulus that relaxes; keeps_dents: whether
    dents stay. `memory`: what the loads so far have left; `inherited`: the errors of that.
    """

    def __init__(self, sweep: Sweep, elements: Sequence[Element] = (), keeps_dents: bool = False):
        self.working = sweep.working
        self.settings = sweep.settings
        self._sweep = sweep  # of the present load
        self._original = sweep.surface  # in the present precision
        self.memory = Memory(self._original.gap.shape, elements, keeps_dents)
        self.inherited = InheritedError(elements, keeps_dents)
        self._time: float | None = None  # of the load before
        self._failed = ""  # the status of a load that was not solved, with unknown errors

    @property
    def surface(self) -> Surface:
        """The original surface in the present precision."""
        return self._original

    @property
    def dtype(self) -> np.dtype:
        """The present precision; once a load needs double precision, all later ones use it."""
        return self._original.gap.dtype

    @property
    def coarser(self) -> Sequence[CoarseContact]:
        """The contacts of the last load on coarser grids."""
        return self._sweep.coarser

    def loads(self, table: LoadTable) -> list[Load]:
        """Return the loads of the table [load], as `Sweep.loads`, with times and shares."""
        loads = self._sweep.loads(table)
        times = table.time or [0.0] * len(loads)
        return [
            replace(load, time=float(time), share=share)
            for load, time, share in zip(loads, times, _shares(loads), strict=True)
        ]

    def solve(
        self, load: Load, watch: Watch | None = None, unfinished: Unfinished | None = None
    ) -> Contact:
        """Solve a load on what others left, and remember what it leaves; see `Sweep.solve`.
        Collective. The contact is that of the original wall and E*, with inherited errors; once
        these are unknown, later loads keep that status.
        """
        dt = 0.0 if self._time is None else load.time - self._time
        shift, factor = self.memory.position.before(dt)
        lowest = self._lowest(dt)
        self._sweep = self._sweep_on(dt, lowest, factor, load.share)
        load, apart = self._load_on(load, lowest + shift)
        if apart is None:
            contact = self._sweep.solve(load, watch, unfinished)
            if contact.status == "interrupted":
                return contact
            approach = contact.certificate.approach
        else:
            contact = unloaded_contact(self._sweep.working, apart)
            gap = contact.certificate.gap_mean  # 0 of a flat surface
            of_gap = self.inherited.of_gap / gap if gap > 0 else 0.0
            certificate = replace(contact.certificate, errors=(0.0, of_gap, 0.0))
            contact = replace(contact, certificate=certificate)
            approach = -apart
        approach = approach + lowest + shift
        surface = self._original
        rows, points = surface.gap.shape
        if contact.status != "nonfinite":
            self.memory.after(dt, contact.g[:rows, :points], surface.gap, -approach)
            self._time = load.time
        if not self.inherited.after(dt, contact.certificate):
            self._failed = self._failed or contact.status
        return self._as_original(contact, load, factor, float(approach))

    def _lowest(self, dt: float) -> float:
        h = self._original.gap + self.memory.before(dt)
        return float(self._original.grid.comm.min([h.min(initial=np.inf)])[0])

    def _sweep_on(self, dt: float, lowest: float, factor: float, share: float) -> Sweep:
        """Return the sweep of a load on the changed wall, lowered by `lowest`, with E* x factor, to
        a share of the accuracy.
        """
        settings = self.settings
        if settings.accuracy is not None and settings.precision != "single":
            finest = min(settings.accuracy, FINEST + 2 * self.working.model.body.error)
            accuracy = max(share * settings.accuracy, finest)
            settings = settings.model_copy(update={"accuracy": accuracy})
        if self.dtype == DOUBLE and settings.precision == "auto":
            settings = settings.model_copy(update={"precision": "double"})

        def changed(dtype: np.dtype) -> Surface:
            if dtype != self.dtype:
                self._original = self.working.make_surface(dtype)
            h = self._original.gap + self.memory.before(dt) - lowest
            return replace(
                self._original, h=np.maximum(h, 0, out=h).astype(dtype), add_spectrum=None
            )

        model = self.working.model
        error = self.inherited.before(dt)
        model = replace(model, E_star=factor * model.E_star, height_error=error)
        return Sweep(changed, settings, model, of_result=self.settings.accuracy)

    def _load_on(self, load: Load, nearer: float) -> tuple[Load, float | None]:
        """Return a load as it is on the changed wall, and how far bodies are apart (None: pressed).
        Collective. nearer: approach when it first touches.
        """
        unit = self._original.height_unit
        if load.quantity == "approach":
            load = replace(load, value=load.value - nearer * unit)
            apart = -load.value / unit
        elif load.quantity == "gap_mean":
            working = self._sweep.working
            apart = load.value / unit - working.heights.top / self._original.grid.a
        else:
            apart = 0.0 if load.value == 0 else -1.0
        return load, apart if apart >= 0 else None

    def _as_original(self, contact: Contact, load: Load, factor: float, approach: float) -> Contact:
        """Return a contact on the original wall with the original E*, with the dents so far."""
        np.multiply(contact.p, contact.p.dtype.type(factor), out=contact.p)
        certificate = contact.certificate
        # the energy of a body that relaxes is not that of its displacement
        energy = nan if self.memory.body.elements else certificate.energy
        return replace(
            contact,
            status=self._failed or contact.status,
            surface=self._original,
            E_star=self.working.model.E_star,
            certificate=replace(certificate, approach=approach, energy=energy),
            accuracy=self.settings.tolerance,
            dents=self.memory.dents,
        )

    # -- the memory of the last load, for a run that goes on later

    def numbers(self) -> dict[str, Any]:
        """Return what the memory holds beside its fields."""
        position = self.memory.position
        return {
            "time": self._time,
            "position": [position.u, *position.q],
            "failed": self._failed,
        } | self.inherited.numbers()

    def restore(self, fields: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
        """Take up the fields of a stored memory, local slabs, and its `numbers`."""
        self.memory.restore(fields, numbers["position"])
        self._time = numbers["time"]
        self.inherited.restore(numbers)
        self._failed = numbers["failed"]

    @property
    def has_begun(self) -> bool:
        """Whether a load has been solved, or a memory restored."""
        return self._time is not None
