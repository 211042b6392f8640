"""Run a scene with files: the way from a command or a script to a result file.

`run_scene` reads the scene, listens for signals, opens the result file, compiles the kernels, and
makes surface and loads (loads.py: Run). A `_Recorder` writes each load when it is finished. A
stopped run goes on later with the loads that are missing, from the gap of the one that was begun.
"""

import json
import time
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..contact import all_numbers
from ..contact.fields import heights_of
from ..driver.precision_forecast import first_of_scene, precisions
from ..driver.warmup import compile_once
from ..output.fields import FIELDS
from ..output.folder import clear, has_begun, is_held, of_earlier_version, partial_folder
from ..output.read import read_partial, read_result
from ..output.record import RunFile
from ..output.result import Result
from ..output.summary import surface_line
from ..parallel.comm import Comm
from ..parallel.guard import on_rank_0
from ..parallel.interrupt import Interrupt, Stopped
from ..parallel.thread_count import oversubscription
from ..parallel.world import comm_of, world
from ..scene import Scene, load_scene, with_overrides
from ..surface import Surface, grid_of
from ..surface.number_range import field_dtype
from ..util.errors import SceneError
from ..util.versions import versions
from .in_memory import surfaces_of_scene
from .loads import Run, SolvedLoad, check, step_attributes, worst_status
from .memory import require_memory
from .progress import Reporter
from .solutions import Solutions
from .states import forget, keep_gap, recall, remember, unfinished_load


def run_scene(
    scene: str | PathLike | Scene,
    overrides: Iterable[str] = (),
    out: str | PathLike | None = None,
    force: bool = False,
    quiet: bool = False,
    comm: Any = None,
) -> Solutions:
    """Solve a scene and write its result file, as `hpc-gfmd run` does. Collective.

    If an interrupted run of the same scene lies at its output, it is continued. On a signal to stop
    (SIGINT, SIGTERM, ...), or when machine.wall_seconds are over, the run stops after the current
    iteration, and what is finished is kept.

    Parameters
    ----------
    scene
        Path of a TOML file, or a scene.Scene.
    overrides
        Texts "table.key=value"; only for a scene in a file.
    out
        Path of the result; default: that in the scene.
    force
        Start from the beginning and overwrite whatever is there: an interrupted run, or the result
        of another scene.
    quiet
        Print nothing.
    comm
        A communicator of mpi4py; default: all processes that the MPI launcher started.

    Returns
    -------
    Solutions
        The finished loads, with `path` and `exit_code`; an interrupted run raises nothing.

    Raises
    ------
    SceneError
        On all ranks, for an invalid scene, too little memory, or a result that would be lost.
    GfmdError
        For what failed while running.
    """
    begun = time.monotonic()
    comm = world() if comm is None else comm_of(comm)
    scene = on_rank_0(comm, "reading the scene", lambda: _read_scene(scene, overrides, out))
    check(scene)
    surfaces = surfaces_of_scene(comm, scene)
    threads = surfaces.threads
    size = surfaces.size
    reporter = Reporter(comm, scene.solver, quiet)
    grid = grid_of(size.n, size.lengths, comm, free=scene.surface.free, threads=threads)
    require_memory(comm, scene, size, threads)
    head = {"scene": scene.to_toml(), "identity": scene.identity(), "versions": versions()}
    output = scene.output
    how_to_continue = f"continue with: hpc-gfmd restart {output.path}"

    def announce() -> None:
        reporter.done()  # the bar, on whose line the text would stand
        reporter.say(f"stopping after this iteration; finished loads are kept, {how_to_continue}")

    with (
        Interrupt(comm, scene.machine.wall_seconds, announce) as interrupt,
        RunFile(
            comm,
            output.path,
            size.n,
            grid.nominal_rows,
            head,
            {},
            force=force,
            about=all_numbers(),
            compressed=output.compression,
            dtype=output.dtype,
        ) as file,
    ):
        for line in [*file.notes, *scene.warnings(), oversubscription(comm, threads)]:
            if line:
                reporter.say(f"note: {line}")
        compile_once(comm, scene, partial(step_attributes, scene, 0, seconds=0.0), reporter.say)
        recorder: _Recorder | None = None
        exit_code = None
        try:
            recorder = _Recorder(Run(scene, surfaces, reporter), file, interrupt)
            recorder.write_head(threads, begun)
            status = recorder.all_loads()
        except Stopped as stopped:  # perhaps while the surface was made
            progress = "no load had begun" if recorder is None else recorder.progress_text()
            reporter.say(f"stopped: {progress}; {how_to_continue}")
            status = "interrupted"
            exit_code = stopped.exit_code
    steps = [*file.finished.values()]
    path = file.path

    def make_result() -> Result:
        """Read the file, whose numbers are known."""
        return replace(read_result(path), steps=steps)

    return Solutions(steps, make_result, status=status, path=path, exit_code=exit_code)


class _Recorder:
    """Solves the loads of a run and writes each to its file."""

    def __init__(self, run: Run, file: RunFile, interrupt: Interrupt) -> None:
        self.run = run
        self.scene = run.scene
        self.reporter = run.reporter
        self.file = file
        self.interrupt = interrupt
        self.unfinished = ""  # the load that was stopped before it converged, for messages

    def progress_text(self) -> str:
        """Return how far the run has got, for a message: "2 of 5 loads are finished, ..."."""
        count = len(self.file.finished)
        are = "is" if count == 1 else "are"
        return f"{count} of {len(self.run.loads)} loads {are} finished{self.unfinished}"

    def write_head(self, threads: int, begun: float) -> None:
        """Write the surface, once it has passed all checks, and tell about it; threads: of a rank;
        begun: time at which the preparation began. Collective.
        """
        run = self.run
        surface = run.surface
        self._require_the_same_heights(surface)
        self._require_storable(surface, *(load.value for load in run.loads if load.is_pressure))
        self.file.update(
            run.attributes,
            heights_of(surface) if "heights" in self.scene.output.fields else None,
            heights=surface.checksum or "",
            setup_seconds=time.monotonic() - begun,
        )
        for note in run.attributes.get("notes", []):
            self.reporter.say(f"note: {note}")
        self.reporter.say(self._headline(threads, time.monotonic() - begun))

    def _require_the_same_heights(self, surface: Surface) -> None:
        earlier = self.file.earlier.get("heights")
        is_resumed = earlier is not None or bool(self.file.finished)
        if is_resumed and (earlier or None) != surface.checksum:
            raise SceneError(
                f"{self.file.partial}: of other heights than surface.path has now (content, shape"
                " or size), allowed: the same; run with --force for the new ones"
            )

    def all_loads(self) -> str:
        """Solve the missing loads, write the result, return the worst status. Collective."""
        run = self.run
        finished = self.file.finished
        run.show(finished)
        missing = [index for index in range(len(run.loads)) if index not in finished]
        if missing:
            self.file.require_space(len(missing), self._types_of_fields(missing))
            self.interrupt.require_time()
            self._solve(missing)
        status = worst_status([*self.file.finished.values()])
        self.file.finish(status)
        for line in run.table.end():
            self.reporter.say(line)
        return status

    def _types_of_fields(self, missing: list[int]) -> list[np.dtype]:
        """Return the types of the fields of missing loads, double where a load may need it."""
        n_x, n_y = self.run.surface.n
        forecast = precisions(self.scene, (n_x, n_y), np.float64)
        of_loads = [np.result_type(self.run.sweep.dtype, forecast[index]) for index in missing]
        count = len([name for name in self.scene.output.fields if name in FIELDS])
        return of_loads * count

    def _solve(self, missing: list[int]) -> None:
        """Solve and write these loads, one that has to stop with its gap alone. Collective."""
        run = self.run
        if run.history is not None and missing[0] > 0:
            recall(self.file, run.history, missing[0] - 1, self.reporter.say)
        unfinished = partial(unfinished_load, self.file, run)
        for load in run.solve(missing, self.interrupt.poll, unfinished):
            index = load.index
            if load.contact.status == "interrupted":
                keep_gap(self.file, load, run.sweep.coarser)
                count = load.contact.iterations
                plural = "s" * (count != 1)
                self.unfinished = f", load {index + 1} after {count} iteration{plural}"
                raise Stopped(self.interrupt.poll())
            self._write(load)
            run.show({index: load.numbers})
            del load  # its fields make room for the next one
            if index != missing[-1] and (number := self.interrupt.poll()):
                raise Stopped(number)

    def _write(self, load: SolvedLoad) -> None:
        """Write a finished load, and what it leaves for later ones in a history. Collective."""
        contact = load.contact
        self._require_storable(contact.surface, contact.wall_pressure)
        names = self.scene.output.fields
        fields: dict[str, Any] = {name: contact.field(name) for name in names if name in FIELDS}
        history = self.run.history
        if history is not None:
            remember(self.file, history, load)
        self.file.write_step(load.index, load.numbers, fields)
        if history is not None:
            forget(self.file, load.index - 1)

    def _require_storable(self, surface: Surface, *pressures: float) -> None:
        """Raise SceneError if output.dtype = "single" cannot hold the fields at these pressures."""
        if self.scene.output.dtype != "single":
            return
        for name in self.scene.output.fields:
            for p_mean in pressures:
                if name == "pressure" and p_mean <= 0:
                    continue
                if field_dtype(name, np.float32, p_mean, surface) != np.float32:
                    raise SceneError(
                        f'output.dtype: found "single", which cannot hold the {name} at a mean'
                        f" pressure of {p_mean:g} (one unit of height: {surface.height_unit:g}),"
                        ' allowed: "double"'
                    )

    def _headline(self, threads: int, seconds: float) -> str:
        """Return the line on surface, ranks and precision; `seconds`: time of the preparation."""
        scene = self.scene
        run = self.run
        ranks = self.file.comm.size
        settings = scene.solver
        precision = first_of_scene(scene).name
        if settings.precision == "auto" and precision == "float32":
            precision += " until a load needs float64"
        return (
            f"{scene.title or scene.surface.kind}: {surface_line(run.attributes)}"
            f"{'' if run.surface.reduced_axis is None else ', varies along one axis only'};"
            f" {ranks} rank{'s' * (ranks > 1)} of {threads} thread{'s' * (threads > 1)},"
            f" {precision},"
            f" {'accuracy' if settings.accuracy else 'residual'} {settings.tolerance:g}; ready"
            f" after {seconds:.1f} s"
        )


def restart(
    path: str | PathLike,
    overrides: Iterable[str] = (),
    quiet: bool = False,
    comm: Comm | None = None,
) -> Solutions:
    """Continue an interrupted run, on any number of ranks. Collective.

    Parameters
    ----------
    path
        The result file that the run writes.
    overrides
        Texts "machine.key=value"; nothing else of the scene can be changed.
    quiet
        Print nothing.
    comm
        All ranks; default: all processes that the MPI launcher started.

    Returns
    -------
    Solutions
        As for `run_scene`.

    Raises
    ------
    SceneError
        If there is no such run.
    GfmdError
        For what failed while running.
    """
    comm = comm or world()
    scene = on_rank_0(comm, "reading the interrupted run", lambda: _interrupted_scene(Path(path)))
    return run_scene(with_overrides(scene, overrides, "machine"), out=path, quiet=quiet, comm=comm)


def _interrupted_scene(path: Path) -> Scene:
    """Return the scene of the interrupted run that writes `path`; remove a folder left over."""
    folder = partial_folder(path)
    if not (has_begun(folder) or of_earlier_version(folder) or is_held(folder)):
        clear(folder)  # what a run that died after it had finished the file left
    if not folder.is_dir():
        if path.suffix == ".partial":
            reason = f"is the folder of a run: hpc-gfmd restart {path.with_suffix('')}"
        elif path.is_file():
            reason = "is complete already"
        else:
            reason = "has no interrupted run beside it"
        raise SceneError(f"{path}: {reason}, allowed: the result file of an interrupted run")
    return read_partial(path).scene


def _read_scene(
    scene: str | PathLike | Scene, overrides: Iterable[str], out: str | PathLike | None
) -> Scene:
    """Return the scene of a run from the arguments of `run_scene`. Raises SceneError."""
    if not isinstance(scene, str | PathLike | Scene):
        raise SceneError(
            f"hpc_gfmd.run: found a {type(scene).__name__}, allowed: the path of a scene file, or a"
            " Scene: hpc_gfmd.scene.Scene.from_dict({...})"
        )
    if not isinstance(scene, Scene):
        scene = load_scene(scene, overrides)
    elif [*overrides]:
        raise SceneError("overrides: found with a Scene, allowed: with the path of a scene file")
    if out is not None:
        scene = with_overrides(scene, [f"output.path={json.dumps(str(out))}"], "output")
    return scene


run = run_scene  # its name on the package's face
