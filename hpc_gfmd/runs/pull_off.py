"""The load at which bodies that adhere come apart, bisected to an error after a sweep."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..driver.branches import RETRACTION
from ..scene import Scene
from ..scene.settings import PRESSURES
from ..util.errors import SceneError
from .loads import Run, SolvedLoad

FIRST_PULL = 0.25  # over the attraction at the last load, where no load of the sweep pulls


def require_pull(scene: Scene, error: Any, several: bool) -> None:
    """Raise SceneError unless the loads of a scene pull adhering bodies apart, and error fits."""
    is_number = isinstance(error, int | float) and not isinstance(error, bool)
    if not (is_number and 1e-4 <= error <= 0.5):
        raise SceneError(f"pull_off_error: found {error!r}, allowed: a number from 1e-4 to 0.5")
    name, _ = scene.load.prescribed
    if scene.material.adhesion is None or scene.load.branch != RETRACTION:
        present = f'branch = "{scene.load.branch}"' if scene.material.adhesion else "no adhesion"
        raise SceneError(
            f'pull_off_error: found {present}, allowed: with adhesion and branch = "retraction"'
        )
    if name not in PRESSURES or not several:
        present = name if name not in PRESSURES else "a single load"
        raise SceneError(
            f"pull_off_error: found {present}, allowed: a list of pressures, p_star or forces"
        )


class PullOff:
    """Pulls the bodies apart by further loads, each from the smallest that held, until the pull-off
    is known to `error`, relative to the load that separates. `order`: the solved loads as a sweep
    has them.
    """

    def __init__(self, run: Run, error: float) -> None:
        self.run = run
        self.error = error
        self.order: list[int] = []
        self._held: float | None = None  # mean pressures
        self._lost: float | None = None
        self._gap = np.empty(0)  # of the load that is held
        self._attraction = 0.0  # of the load that is held

    def solve(self) -> Iterator[SolvedLoad]:
        """Yield the loads of the run and then the further ones."""
        for load in self.run.solve():
            self.order.append(load.index)
            if self._lost is None:
                self._learn(load)
            yield load
        place = self._place_of_further()
        while (pressure := self._next()) is not None:
            load = self.run.solve_further(pressure, self._gap)
            held = self._learn(load)
            self.order.insert(place, load.index)
            place += held is True
            yield load
            if held is None:
                return

    def _place_of_further(self) -> int:
        """Return the place in `order` behind the load that is held."""
        pressures = [load.value for load in self.run.loads]
        return len(pressures) if self._lost is None else pressures.index(self._lost)

    def _learn(self, load: SolvedLoad) -> bool | None:
        """Return whether a load is held, None for one that did not converge, and store it."""
        contact = load.contact
        if contact.is_separated:
            self._lost = None if self._held is None else self.run.loads[load.index].value
            return False
        if contact.status != "converged":
            return None
        self._held = self.run.loads[load.index].value
        self._gap = contact.g.copy()
        self._attraction = load.numbers["attraction"]
        return True

    def _next(self) -> float | None:
        if self._held is None:
            return None
        if self._lost is None:
            return 2 * self._held if self._held < 0 else -FIRST_PULL * self._attraction
        middle = (self._held + self._lost) / 2
        return middle if self._held - self._lost > self.error * abs(self._lost) else None
