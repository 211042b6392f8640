"""Runs in pieces: stopped or dead wherever a test likes, continued, and compared with the run that
was not disturbed: the same within the accuracy."""

from contacts import rough
from result_files import assert_same_steps

from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import read_result
from hpc_gfmd.parallel import h5
from hpc_gfmd.parallel.interrupt import Interrupt
from hpc_gfmd.runs import simulation
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.scene import Scene

# cold, warm, cold, closed at once, warm from the one before that
LOADS = [0.05, 0.06, 0.3, 9.0, 0.33]
NEVER = 10**9


class Died(BaseException):
    """What no part of the program catches."""


class Chance(Interrupt):
    """Stops the run, or lets it die, when it has been polled `after` times."""

    after = NEVER
    dies = False
    polled = 0

    def poll(self):
        type(self).polled += 1
        if self.polled >= self.after and self.dies:
            raise Died
        stop = self.polled >= self.after
        self.agreed = 15 if stop else 0
        return stop


class Pieces:
    """Runs of scenes in a folder; comm: of all of them."""

    def __init__(self, monkeypatch, comm, folder):
        self.comm = comm
        self.path = folder / "pieces.h5"
        self.whole = folder / "whole.h5"
        self.chance = type("Chance", (Chance,), {})
        monkeypatch.setattr(simulation, "Interrupt", self.chance)
        # for speed: there are many runs
        monkeypatch.setattr(simulation, "compile_once", lambda *_: None)
        monkeypatch.setattr(h5, "sync", lambda *_, **__: None)

    def undisturbed(self, scene):
        """Run without interruption; returns how often it was polled."""
        self.chance.polled = 0
        self.chance.after = NEVER
        assert run_scene(scene, out=self.whole, quiet=True, comm=self.comm).exit_code in (0, 3)
        return self.chance.polled

    def run(self, scene, *pieces, comms=()):
        """Run in pieces (after, dies) and then to the end; comms: of the pieces, where others than
        that of all."""
        for k, (after, dies) in enumerate([*pieces, (NEVER, False)]):
            comm = comms[k] if k < len(comms) else self.comm
            chance = self.chance
            chance.polled = 0
            chance.after = after
            chance.dies = dies
            status = None
            if comm is self.comm or self.comm.rank == 0:
                try:
                    status = run_scene(scene, out=self.path, quiet=True, comm=comm).status
                except Died:
                    status = "died"
            self.comm.barrier()
            assert status is None or (status in ("died", "interrupted")) == (after < NEVER)
        assert not partial_folder(self.path).exists()

    def compare(self, rel):
        """All numbers and fields are the same within a relative tolerance."""
        found = read_result(self.path)
        wanted = read_result(self.whole)
        assert found.indices == wanted.indices
        assert_same_steps(found, wanted, rel)
        self.comm.barrier()


def scene(solver, loads=LOADS, fields=("gap", "pressure"), boundary="periodic", **settings):
    """A small rough contact in double precision; loads: p*, or a table [load]."""
    solver = {"name": solver, "accuracy": 1e-2, "precision": "double"} | settings
    load = loads if isinstance(loads, dict) else {"p_star": loads}
    return Scene.from_dict(
        {
            "surface": rough((2, 8, 2), boundary=boundary),
            "load": load,
            "solver": solver,
            "output": {"fields": list(fields)},
        }
    )
