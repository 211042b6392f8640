"""From a scene to its result file: the composition, top to bottom."""

import json
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..contact.contact import heights_of
from ..driver.load_target import LoadTarget
from ..driver.precision import first_precision
from ..driver.sweep import Step, Sweep
from ..driver.warmup import compile_once
from ..output.fields import FIELDS
from ..output.folder import HEAD, clear, is_held, partial_folder
from ..output.read import read_partial
from ..output.record import RunFile
from ..output.table import GrowingTable, surface_line
from ..parallel import wisdom
from ..parallel.comm import Comm
from ..parallel.guard import guarded, on_rank_0
from ..parallel.interrupt import Interrupt, Stopped
from ..parallel.world import threads_of, world
from ..scene import Output, Scene, Solver, load_scene, with_overrides
from ..solvers.base import Progress
from ..surface import Surface, build_surface, grid_of, surface_size
from ..surface.units import field_dtype
from ..util.errors import GfmdError, SceneError
from ..util.versions import versions
from .composition import (
    asked,
    check,
    load_shown,
    step_attributes,
    surface_attributes,
    sweep_of,
    worst,
)
from .memory import require_memory
from .progress import Reporter

OTHER_HEIGHTS = (
    "{}: of other heights than surface.path has now (content, shape or size), allowed: the same;"
    " run with --force for the new ones"
)


@dataclass(frozen=True)
class RunResult:
    """path: the result file; steps: attributes of every load step; status: the worst of them;
    exit_code: of the command line."""

    path: Path
    steps: list[dict]
    status: str
    exit_code: int


def run_scene(
    scene: str | PathLike | Scene,
    overrides: Iterable[str] = (),
    out: str | PathLike | None = None,
    force: bool = False,
    quiet: bool = False,
    comm: Any = None,
) -> RunResult:
    """Solve a scene and write its result file, as `hpc-gfmd run` does. Collective.

    Goes on with an interrupted run of the same scene that lies at its output.

    Parameters
    ----------
    scene
        Path of a TOML file, or a scene.Scene.
    overrides
        Texts "table.key=value".
    out
        Path of the result instead of the scene's.
    force
        Begin anew whatever is there: an interrupted run, or the result of another scene.
    quiet
        Print nothing.
    comm
        A communicator of parallel.comm; default: all processes that the MPI launcher started.

    Returns
    -------
    RunResult
        What was written, and how it went.

    Raises
    ------
    SceneError
        On all ranks, for a wrong scene.
    GfmdError
        For what failed while running.
    """
    begun = time.monotonic()
    comm = comm or world()
    scene = on_rank_0(comm, "reading the scene", lambda: _read_scene(scene, overrides, out))
    check(scene)
    n, sizes = on_rank_0(comm, "reading the surface", lambda: surface_size(scene.surface))
    threads = threads_of(comm, scene.machine.threads)
    say = Reporter(comm, scene.solver, quiet)
    require_memory(comm, scene, n, sizes, threads)
    rows = grid_of(n, sizes, comm, free=scene.surface.free).nominal_rows
    head = {"scene": scene.to_toml(), "identity": scene.identity(), "versions": versions()}

    with (
        Interrupt(comm, scene.machine.wall_seconds, scene.machine.checkpoint_seconds) as interrupt,
        RunFile(
            comm,
            scene.output.path,
            n,
            rows,
            head,
            {},
            force=force,
            compressed=scene.output.compression,
            dtype=scene.output.dtype,
        ) as file,
    ):
        for line in [*file.notes, *scene.warnings()]:
            say.say(f"note: {line}")
        try:
            return _solve(comm, scene, n, threads, file, say, interrupt, begun)
        except Stopped:  # between two iterations: the last checkpoint is what a restart begins from
            return _stopped(file, say, interrupt)


def _solve(
    comm: Comm,
    scene: Scene,
    n: tuple[int, int],
    threads: int,
    file: RunFile,
    say: Reporter,
    interrupt: Interrupt,
    begun: float,
) -> RunResult:
    """Surface, sweep and all steps; n: size of the surface, begun: time at which the run began."""
    if file.resumed and comm.rank == 0:
        wisdom.take_from(file.partial)
    compile_once(
        comm,
        scene.solver,
        scene.surface.boundary or "periodic",
        scene.material,
        asked(scene.output),
        say.say,
    )
    low = scene.solver.low_memory
    sweep = sweep_of(scene, lambda dtype: build_surface(scene.surface, comm, dtype, threads, low))
    loads = sweep.pressures(scene.load)
    _require_same_heights(file, sweep.surface)
    _require_storable(
        scene.output, sweep.surface, [p for p in loads if not isinstance(p, LoadTarget)]
    )
    attributes = surface_attributes(scene, sweep.surface)
    stored = heights_of(sweep.surface) if "heights" in scene.output.fields else None
    file.update(
        attributes,
        stored,
        heights=sweep.surface.checksum or "",
        setup_seconds=time.monotonic() - begun,
    )
    for line in sweep.surface.notes:
        say.say(f"note: {line}")
    say.say(_headline(scene, sweep.surface, n, comm, time.monotonic() - begun))
    run = _Run(comm, scene, file, sweep, say, interrupt, attributes)
    return run.all_steps(loads)


def _stopped(file: RunFile, say: Reporter, interrupt: Interrupt) -> RunResult:
    """What a run ends with that was asked to stop."""
    say.say(f"stopped; continue with: hpc-gfmd restart {file.path}")
    return RunResult(file.path, [*file.finished.values()], "interrupted", interrupt.exit_code)


def restart(
    path: str | PathLike,
    overrides: Iterable[str] = (),
    quiet: bool = False,
    comm: Comm | None = None,
) -> RunResult:
    """Continue the interrupted run that writes `path`, on any number of ranks. Raises SceneError if
    there is none.

    overrides: "machine.key=value" texts; nothing else of the scene can be changed.
    """
    comm = comm or world()
    with guarded(comm, "reading the interrupted run"):
        if comm.rank == 0:
            folder = partial_folder(path)
            if not ((folder / HEAD).exists() or is_held(folder)):
                clear(folder)  # what a run that died after it had finished the file left
            if not folder.is_dir():
                there = (
                    "is complete already"
                    if Path(path).is_file()
                    else "has no interrupted run beside it"
                )
                if Path(path).suffix == ".partial":
                    there = f"is the folder of a run: hpc-gfmd restart {Path(path).with_suffix('')}"
                raise SceneError(f"{path}: {there}, allowed: the result file of an interrupted run")
        scene = with_overrides(
            Scene.from_toml(read_partial(path).scene_toml, str(path)), overrides, "machine"
        )
    return run_scene(scene, out=path, quiet=quiet, comm=comm)


def _read_scene(
    scene: str | PathLike | Scene, overrides: Iterable[str], out: str | PathLike | None
) -> Scene:
    if not isinstance(scene, str | PathLike | Scene):
        raise SceneError(
            f"hpc_gfmd.run: found a {type(scene).__name__}, allowed: the path of a scene file, or a"
            " Scene: hpc_gfmd.scene.Scene.from_dict({...})"
        )
    if not isinstance(scene, Scene):
        scene = load_scene(scene, overrides)
    if out is not None:
        output = scene.output.model_dump() | {"path": str(out)}
        scene = Scene.from_dict(
            scene.model_dump(exclude_none=True)
            | {"output": {k: v for k, v in output.items() if v is not None}},
            "-o",
        )
    return scene


def _require_same_heights(file: RunFile, surface: Surface) -> None:
    """Raise SceneError where the run that is resumed was that of another height map; synthetic
    surfaces are known by their scene."""
    known = file.earlier.get("heights")
    if (known is not None or file.finished) and (known or None) != surface.checksum:
        raise SceneError(OTHER_HEIGHTS.format(file.partial))


def _require_storable(output: Output, surface: Surface, pressures: Iterable[float]) -> None:
    """Raise SceneError where a field that is asked for in single precision does not fit into it."""
    for name in output.fields if output.dtype == "single" else ():
        for p_mean in pressures:
            if field_dtype(name, np.float32, p_mean, surface) != np.float32:
                raise SceneError(
                    f'output.dtype: found "single", which cannot hold the {name} at a mean pressure'
                    f" of {p_mean:g} (one unit of height: {surface.height_unit:g}), allowed:"
                    ' "double"'
                )


def _headline(
    scene: Scene, surface: Surface, n: tuple[int, int], comm: Comm, seconds: float
) -> str:
    wanted = (
        f"accuracy {scene.solver.accuracy:g}"
        if scene.solver.accuracy
        else f"residual {scene.solver.residual:g}"
    )
    one_d = "" if surface.reduced_axis is None else ", varies along one axis only"
    known = {
        "n": n,
        "physical_sizes": surface.sizes,
        "h_rms": surface.h_rms,
        "g_rms": surface.g_rms,
        "unit": surface.unit or scene.length_unit,
    }
    return (
        f"{scene.title or scene.surface.kind}: {surface_line(known)}{one_d}; {comm.size}"
        f" rank{'s' * (comm.size > 1)}, {_precision(scene.solver)}, {wanted}; ready after"
        f" {seconds:.1f} s"
    )


def _precision(settings: Solver) -> str:
    first = first_precision(settings).name
    return (
        f"{first} until a load needs float64"
        if settings.precision == "auto" and first == "float32"
        else first
    )


class _Run:
    """The load steps of one run."""

    def __init__(
        self,
        comm: Comm,
        scene: Scene,
        file: RunFile,
        sweep: Sweep,
        say: Reporter,
        interrupt: Interrupt,
        surface: dict[str, Any],
    ):
        self.comm, self.scene, self.file, self.sweep, self.surface = (
            comm,
            scene,
            file,
            sweep,
            surface,
        )
        self.say, self.interrupt, self.table = say, interrupt, GrowingTable(surface)
        self.checkpointable = sweep.surface.reduced_axis is None and (
            sweep.surface.g_rms > 0 or sweep.surface.grid.padded
        )

    def all_steps(self, loads: Sequence[float | LoadTarget]) -> RunResult:
        """Solve what is not finished; returns a RunResult."""
        if self.file.finished:
            self.say.say(self.table.add(self.file.finished))
        unfinished = [index for index in range(len(loads)) if index not in self.file.finished]
        first, midway = self._go_back(unfinished[0], loads) if unfinished else (0, None)
        if unfinished:
            self.interrupt.require_time()
        for index in range(first, max(unfinished, default=-1) + 1):
            status = self._one_step(index, loads, midway if index == first else None)
            if status == "interrupted":
                return _stopped(self.file, self.say, self.interrupt)
        steps = [*self.file.finished.values()]
        status = worst(steps)
        self.file.finish(status)
        for line in self.table.end():
            self.say.say(line)
        return RunResult(self.file.path, steps, status, 0 if status == "converged" else 3)

    def _go_back(
        self, unfinished: int, loads: Sequence[float | LoadTarget]
    ) -> tuple[int, float | None]:
        """To the last checkpoint, so that all goes on as if nothing had happened: loads finished
        since then are repeated, not written again. unfinished: the first load to be solved. Returns
        the load to begin with and, in the middle of it, the seconds spent on it.
        """
        other, first, seconds = False, 0, None  # died before its first checkpoint
        try:
            found = self.file.checkpoint(self.sweep.solver_class.name)
            if found is not None:
                (first,), (step,), (stored,) = found.indices, found.steps, found.fields
                numbers, seconds = json.loads(step["numbers"]), step.get("seconds")
                if first > unfinished:
                    raise SceneError(
                        f"{found.path}: later than load {unfinished + 1}, which has to be solved"
                        " again"
                    )
                other = numbers.get("heights") != self.sweep.surface.checksum
                if not other:
                    self.sweep.restore(
                        lambda grid: {
                            name: field.slab(grid.comm, grid.rows) for name, field in stored.items()
                        },
                        numbers,
                        loads[first],
                    )
        except GfmdError as error:
            self.say.say(f"note: {error}; load {unfinished + 1} begins anew")
            self.sweep.solver = None
            return unfinished, None
        if found is not None and other:
            raise SceneError(OTHER_HEIGHTS.format(found.path))
        if first < unfinished:
            self.say.say(
                f"note: repeating from load {first + 1}, where the last checkpoint is; finished"
                " loads stay as they are"
            )
        return first, seconds

    def _one_step(
        self, index: int, loads: Sequence[float | LoadTarget], midway: float | None
    ) -> str:
        begun = time.monotonic() - (midway or 0.0)
        load = loads[index]
        self.say.step(index, len(loads), *load_shown(self.scene.load, index, self.sweep, load))

        def watch(iterations: int, progress: Progress) -> bool:
            self.say.watch(iterations, progress)
            stop, due = self.interrupt.poll()
            if stop or due:
                self._save(index, self.sweep.state, seconds=time.monotonic() - begun)
            return stop

        try:
            step = self.sweep.solve(load, watch, midway is not None)
        finally:
            self.say.done()
        status = step.contact.outcome.status
        if status == "interrupted":
            return status
        if index not in self.file.finished:
            if isinstance(load, LoadTarget):
                _require_storable(self.scene.output, self.sweep.surface, [step.contact.p_mean])
            self._write(index, step, time.monotonic() - begun)
        stop, _ = self.interrupt.poll()
        if index + 1 < len(loads) and (stop or self.interrupt.cheap()):
            self._save(index + 1, lambda: self.sweep.state(loads[index + 1]))
        return "interrupted" if stop else status

    def _save(
        self, index: int, state: Callable[[], tuple[dict, dict]], seconds: float | None = None
    ) -> None:
        """A checkpoint in the middle of a load (seconds: spent on it so far) or at its
        beginning."""
        if self.checkpointable:
            begun, sweep = time.monotonic(), self.sweep
            if self.comm.rank == 0:
                wisdom.keep_with(self.file.partial)
            self.file.write_checkpoint(
                sweep.surface.grid, sweep.solver_class.name, index, state(), seconds
            )
            self.interrupt.saved(begun)

    def _write(self, index: int, step: Step, seconds: float) -> None:
        """A finished load into the file."""
        attributes = step_attributes(self.scene, index, step, seconds)
        fields: dict[str, Any] = {
            name: step.contact.field(name) for name in self.scene.output.fields if name in FIELDS
        }
        self.file.write_step(index, attributes, fields)
        self.say.say(self.table.add({index: attributes}))
