"""Loads that follow from each other: before each one the wall changes by what the loads before have
left (memory.py), and on the changed wall it is an elastic contact like any other, with its search,
coarser grids, precision and certificate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np

from .memory import Memory
from .sweep import DOUBLE, Sweep, sweep_with
from .without_iterations import unloaded_contact

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..scene import LoadTable
    from ..surface import Surface
    from .drive import Watch
    from .grid_errors import CoarseContact
    from .load import Load, Unfinished
    from .memory import Element


class History:
    """Solves loads with a memory, in the place of a Sweep that is at its first load on the original
    surface.

    Each load starts anew: a start from the load before saves nothing, as the wall has changed.
    elements: share and time of each that relaxes; `memory`: what the loads so far have left;
    `errors`: largest of area, mean gap and pressure field so far.
    """

    def __init__(self, sweep: Sweep, elements: Sequence[Element] = (), keeps_dents: bool = False):
        self.working = sweep.working
        self.settings = sweep.settings
        self._first = sweep
        self._sweep = sweep  # of the present load
        self._original = sweep.surface  # in the present precision
        self.memory = Memory(self._original.gap.shape, elements, keeps_dents)
        self.errors = (0.0, 0.0, 0.0)
        self._time: float | None = None  # of the load before
        self._failed = ""  # the status of the first load that did not converge

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
        """Return the loads of the table [load] of a scene and their times, as `Sweep.loads`."""
        loads = self._first.loads(table)
        times = table.time or [0.0] * len(loads)
        return [replace(load, time=float(time)) for load, time in zip(loads, times, strict=True)]

    def solve(
        self, load: Load, watch: Watch | None = None, unfinished: Unfinished | None = None
    ) -> Contact:
        """Solve a load on what the loads before have left, and remember what it leaves; see
        `Sweep.solve`.

        The contact is that with the original wall and E*; its errors are the largest so far, and
        once a load has failed its status is that of all later ones. Collective.
        """
        dt = 0.0 if self._time is None else load.time - self._time
        shift, factor = self.memory.position.before(dt)
        lowest = self._lowest(dt)
        self._sweep = self._sweep_on(dt, lowest, factor)
        load, apart = self._load_on(load, lowest + shift)
        if apart is None:
            contact = self._sweep.solve(load, watch, unfinished)
            if contact.status == "interrupted":
                return contact
            approach = contact.certificate.approach
        else:
            criterion = self._sweep.starter.criterion
            contact = unloaded_contact(self._sweep.working, load, criterion, apart)
            approach = -apart
        approach = approach + lowest + shift
        surface = self._original
        rows, points = surface.gap.shape
        if contact.status != "nonfinite":
            self.memory.after(dt, contact.g[:rows, :points], surface.gap, -approach)
            self._time = load.time
        return self._as_original(contact, factor, float(approach))

    def _lowest(self, dt: float) -> float:
        """Return the smallest initial gap of the changed wall. Collective."""
        h = self._original.gap + self.memory.before(dt)
        return float(self._original.grid.comm.min([h.min(initial=np.inf)])[0])

    def _sweep_on(self, dt: float, lowest: float, factor: float) -> Sweep:
        """Return the sweep of a load on the changed wall, lowered by `lowest`, with E* x factor."""
        settings = self.settings
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
        model = replace(model, E_star=factor * model.E_star)
        return sweep_with(changed, settings, model)

    def _load_on(self, load: Load, nearer: float) -> tuple[Load, float | None]:
        """Return a load as it is on the changed wall, and how far the bodies are apart (None:
        pressed together).

        nearer: by how much the body has come nearer when it first touches the changed wall.
        Collective.
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

    def _as_original(self, contact: Contact, factor: float, approach: float) -> Contact:
        """Return a contact on the original wall and with the original E*, which are those of its
        units, with the dents and the errors of all loads so far."""
        np.multiply(contact.p, contact.p.dtype.type(factor), out=contact.p)
        if contact.status == "converged":
            contact = replace(contact, status=self._failed or "converged")
        else:
            self._failed = contact.status
        certificate = contact.certificate
        worst = np.maximum(self.errors, certificate.errors).tolist()
        self.errors = (worst[0], worst[1], worst[2])
        # the energy of a body that relaxes is not that of its displacement
        energy = nan if self.memory.body.elements else certificate.energy
        return replace(
            contact,
            surface=self._original,
            E_star=self.working.model.E_star,
            certificate=replace(certificate, errors=self.errors, approach=approach, energy=energy),
            dents=self.memory.dents,
        )

    # -- the memory of the last load, for a run that goes on later

    def numbers(self) -> dict[str, Any]:
        """Return what the memory holds beside its fields."""
        position = self.memory.position
        return {
            "time": self._time,
            "position": [position.u, *position.q],
            "errors": list(self.errors),
            "failed": self._failed,
        }

    def restore(self, fields: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
        """Take up the fields of a stored memory, local slabs, and its `numbers`."""
        self.memory.restore(fields, numbers["position"])
        self._time = numbers["time"]
        self.errors = tuple(numbers["errors"])
        self._failed = numbers["failed"]

    @property
    def has_begun(self) -> bool:
        """Whether a load has been solved, or a memory restored."""
        return self._time is not None
