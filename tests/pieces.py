"""Runs that are interrupted or killed at chosen points, resumed, and compared with an uninterrupted
run: results agree within the accuracy."""

import signal

from contacts import rough
from mpi.same import from_rank_0
from result_files import assert_same_steps

from hpc_gfmd.output import record
from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import read_result
from hpc_gfmd.parallel import committed, h5
from hpc_gfmd.parallel.interrupt import Interrupt
from hpc_gfmd.runs import simulation
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.scene import Scene

# started cold, warm, cold, in full contact, warm from the third
LOADS = [0.05, 0.06, 0.3, 9.0, 0.33]
NEVER = 10**9


class Died(BaseException):
    """An exception that no part of the program catches."""


class CountedInterrupt(Interrupt):
    """Stops or kills the run when it has been polled `after` times."""

    after = NEVER
    dies = False
    polled = 0

    def poll(self):
        type(self).polled += 1
        if self.polled >= self.after and self.dies:
            raise Died
        return signal.SIGTERM if self.polled >= self.after else 0


class Pieces:
    """Runs of scenes in a folder, interrupted and uninterrupted; comm: their communicator."""

    def __init__(self, monkeypatch, comm, folder):
        self.comm = comm
        self.path = folder / "pieces.h5"
        self.whole = folder / "whole.h5"
        self.interrupt = type("CountedInterrupt", (CountedInterrupt,), {})
        monkeypatch.setattr(simulation, "Interrupt", self.interrupt)
        # faster, for many runs
        monkeypatch.setattr(simulation, "compile_once", lambda *_: None)
        for module in h5, committed, record:
            monkeypatch.setattr(module, "sync", lambda *_, **__: None)

    def undisturbed(self, scene):
        """Run without interruption; returns how often the interrupt was polled."""
        self.interrupt.polled = 0
        self.interrupt.after = NEVER
        assert run_scene(scene, out=self.whole, quiet=True, comm=self.comm).exit_code in (0, 3)
        return self.interrupt.polled

    def run(self, scene, *pieces, comms=()):
        """Run in pieces (after, dies), then to the end.

        comms: communicators of the first pieces, if other than `comm`.
        """
        for k, (after, dies) in enumerate([*pieces, (NEVER, False)]):
            comm = comms[k] if k < len(comms) else self.comm
            interrupt = self.interrupt
            interrupt.polled = 0
            interrupt.after = after
            interrupt.dies = dies
            if comm is self.comm:
                status = self._piece(scene, comm)
                comm.barrier()
            else:
                status = from_rank_0(self.comm, lambda comm=comm: self._piece(scene, comm))
            assert (status in ("died", "interrupted")) == (after < NEVER)
        assert not partial_folder(self.path).exists()

    def _piece(self, scene, comm):
        """Run or resume; returns the status."""
        try:
            return run_scene(scene, out=self.path, quiet=True, comm=comm).status
        except Died:
            return "died"

    def compare(self, rel):
        """Numbers and fields agree with the uninterrupted run within a relative tolerance."""
        resumed = read_result(self.path)
        uninterrupted = read_result(self.whole)
        assert resumed.indices == uninterrupted.indices
        assert_same_steps(resumed, uninterrupted, rel)
        self.comm.barrier()


def scene(
    solver, loads=LOADS, fields=("gap", "pressure"), boundary="periodic", material=(), **settings
):
    """The Scene of a small rough contact in double precision; loads: p*, or a [load] table;
    material: the [material] table."""
    solver = {"name": solver, "accuracy": 1e-2, "precision": "double"} | settings
    load = loads if isinstance(loads, dict) else {"p_star": loads}
    return Scene.from_dict(
        {
            "surface": rough((2, 8, 2), boundary=boundary),
            "load": load,
            "material": dict(material),
            "solver": solver,
            "output": {"fields": list(fields)},
        }
    )
