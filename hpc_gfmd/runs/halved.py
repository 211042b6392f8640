"""A history with another step in the middle of each, which shows what the time step changes."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..output.summary import is_number
from ..parallel.comm import Comm
from ..scene import Scene
from ..util.errors import SceneError
from .in_memory import solve_loads, surfaces_of_scene
from .loads import with_loads

NUMBERS = {"a_r": "contact area", "gap_mean": "mean gap", "p": "pressure"}
# Measured on 16 histories of a small wall: the mean gap has 1.2 to 1.4 for steps up to the
# relaxation time, up to 2.2 for longer ones, the area of few points up to 2.5.
OF_STEPS = (
    "the error is about 1.3 times as large, up to 3 times if steps are longer than relaxation times"
)


def require_steps(scene: Scene) -> None:
    """Raise SceneError for a scene without time steps to halve."""
    if len(set(scene.load.time or ())) < 2:
        raise SceneError("--halve-steps: found no time steps, allowed: with load.time")


def with_halved_steps(scene: Scene) -> Scene:
    """Return a history with a load in the middle of each step that takes time."""
    name, values = scene.load.prescribed
    times = scene.load.time or ()
    loads = {name: _with_middles(values, times), "time": _with_middles(times, times)}
    output = scene.output.model_copy(update={"fields": (), "distributions": (), "observables": ()})
    return with_loads(scene.model_copy(update={"output": output}), **loads)


def _with_middles(numbers: Sequence[float], times: Sequence[float]) -> list[float]:
    """Return numbers of the loads with the mean of two between them, unless that is a jump."""
    result = [numbers[0]]
    for (before, after), (start, end) in zip(pairwise(numbers), pairwise(times), strict=True):
        if end > start:
            result.append(0.5 * (before + after))
        result.append(after)
    return result


def changes_by_halving(scene: Scene, steps: Sequence[dict], comm: Comm) -> dict[str, float]:
    """Return the largest relative changes of a_r, gap_mean and p if the steps of a history (its
    solved loads) are halved. Collective.
    """
    halved = with_halved_steps(scene)
    surfaces = surfaces_of_scene(comm, halved)
    finer, _ = solve_loads(comm, halved, surfaces, progress=False, keep_interrupted=False)
    times = [float(time) for time in scene.load.time or ()]
    is_jump = [False, *(after == before for before, after in pairwise(times))]
    places = np.cumsum([0, *(1 if jump else 2 for jump in is_jump[1:])])
    changes = {}
    for name in NUMBERS:
        pairs = [
            (step.get(name), finer.steps[place].get(name)) for step, place in zip(steps, places)
        ]
        changes[name] = max(
            abs(a - b) / max(abs(a), abs(b), np.finfo(float).tiny)
            for a, b in pairs
            if is_number(a) and is_number(b)
        )
    return changes


def text_of(changes: dict[str, float]) -> str:
    """Return the line that `hpc-gfmd run --halve-steps` prints."""
    listed = ", ".join(
        f"{NUMBERS[name]} by {100 * change:.2g} %" for name, change in changes.items()
    )
    return f"half the time steps change at most: {listed}; {OF_STEPS}"
