"""Compare a contact on many ranks with that of one rank, and count the messages of an iteration.

Run under mpirun: python many_ranks.py LAM_L_OVER_LAM_S PER_NODE FOLDER

PER_NODE ranks share a pretended node. One rank alone saves its fields in the folder, with which
more ranks compare theirs. Rank 0 prints the numbers as JSON.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from contacts import EXACT, field, rough, sweep_of
from decomposition import share_of
from mpi.nodes import on_pretended_nodes, sent_in_a_step

from hpc_gfmd.parallel.world import world

P_STAR = 0.05


def main(lam_l_over_lam_s, per_node, folder):
    """Solve, save or compare the fields, and print the numbers."""
    comm = world()
    if comm.size > 1:
        comm = on_pretended_nodes(comm, lambda rank: rank // per_node, pytest.MonkeyPatch())
    sweep = sweep_of(rough((2, lam_l_over_lam_s, 2)), comm=comm, **EXACT)
    step = sweep.solve(P_STAR * sweep.surface.g_rms)
    numbers = {
        "n": sweep.surface.grid.n[0],
        "status": step.status,
        "contact": step.contact_points,
        "gap_mean": step.gap_mean,
        "levels": sweep.starter.solver.levels.distributed,
        "grids": [grid.comm.size for grid in sweep.working.nested().grids],
    }
    fields = {name: field(step, name) for name in ("pressure", "gap")}
    if comm.size == 1:
        np.savez(folder / "alone.npz", **fields)
    else:
        alone = np.load(folder / "alone.npz")
        mine = slice(*sweep.surface.rows)
        for name, values in fields.items():
            whole = alone[name]
            error = np.abs(values - whole[mine]).max(initial=0) / np.abs(whole).max()
            numbers[name] = float(comm.max([error])[0])
        numbers["messages"] = messages(sweep, comm, per_node)
    if comm.rank == 0:
        print(json.dumps(numbers))


def messages(sweep, comm, per_node):
    """Return the counted and the planned [bytes, messages] of every rank."""
    counted = sent_in_a_step(sweep)
    planned = share_of(sweep.surface.grid.n, sweep.dtype, comm.size, comm.rank, per_node=per_node)
    return comm.allgather([counted, planned.traffic])


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))
