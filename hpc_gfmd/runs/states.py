"""What a run that stops leaves for the next one beside its finished loads: the gap of the load that
was begun, and what the loads of a history left at each point.

A surface that varies along one axis only is solved again, which takes no time.
"""

from collections.abc import Callable, Sequence

import numpy as np

from ..driver.grid_errors import CoarseContact
from ..driver.history import History
from ..driver.load import Unfinished
from ..output.read import CHECKPOINT, MEMORY
from ..output.record import RunFile
from ..util.errors import GfmdError, SceneError
from .loads import Run, SolvedLoad

Say = Callable[[str], None]


def keep_gap(file: RunFile, load: SolvedLoad, coarser: Sequence[CoarseContact]) -> None:
    """Write the gap of a stopped load, with its contacts on coarser grids. Collective."""
    contact = load.contact
    if contact.surface.reduced_axis is not None:
        return
    numbers = {
        "p": contact.p_mean,
        "seconds": load.seconds,
        "iterations": contact.iterations,
        "fft_pairs": contact.fft_pairs,
        "on_coarser_grids": np.ravel(coarser).tolist(),
        "gap_discretisation": contact.gap_discretisation,
    }
    file.write_state(CHECKPOINT, load.index, {"gap": contact.g}, numbers, contact.grid)


def unfinished_load(file: RunFile, run: Run, index: int) -> tuple[Unfinished, float] | None:
    """Return (state, seconds) of a stopped load; None, with a note if unusable. Collective."""
    grid = run.surface.grid
    try:
        checkpoint = file.state(CHECKPOINT, index)
        if checkpoint is None or checkpoint.indices != [index]:
            return None
        if checkpoint.surface["n"] != list(grid.n):
            raise SceneError(f"{checkpoint.path}: of another grid, allowed: the same")
        gap = checkpoint.fields[0]["gap"].slab(grid.comm, grid.rows)
        numbers = checkpoint.steps[0]
        coarser = np.reshape(numbers["on_coarser_grids"], (-1, len(CoarseContact._fields)))
    except (GfmdError, ValueError, TypeError, KeyError) as error:
        run.reporter.say(f"note: {error}; load {index + 1} begins anew")
        return None
    unfinished = Unfinished(
        gap,
        numbers["p"],
        numbers["iterations"],
        numbers["fft_pairs"],
        [CoarseContact(*numbers_of_grid) for numbers_of_grid in coarser],
        numbers.get("gap_discretisation"),
    )
    return unfinished, numbers["seconds"]


def remember(file: RunFile, history: History, load: SolvedLoad) -> None:
    """Write what the loads up to this one left at each point. Collective."""
    if load.contact.surface.reduced_axis is None:
        file.write_state(MEMORY, load.index, history.memory.fields(), history.numbers())


def forget(file: RunFile, index: int) -> None:
    """Remove what the loads up to `index` left: later ones have left more. Collective."""
    file.forget_state(MEMORY, index)


def recall(file: RunFile, history: History, index: int, say: Say) -> None:
    """Take up what loads up to `index` left; only a note if it is unreadable. Collective."""
    grid = history.surface.grid
    try:
        stored = file.state(MEMORY, index)
        if stored is None:
            return
        fields = {
            name: field.slab(grid.comm, history.surface.rows)
            for name, field in stored.fields[0].items()
        }
        history.restore(fields, stored.steps[0])
    except (GfmdError, ValueError, TypeError, KeyError) as error:
        say(f"note: {error}; the loads before load {index + 2} are solved again")
