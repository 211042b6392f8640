"""The same calls on many processes: mpirun -n 4 python mpi_script.py

Every rank calls solve with the same heights and gets the same numbers; fields are its own rows,
`solution.rows`, and `save` writes them into one file, together. Walls that are too large for the
memory of one process are for scenes: mpirun -n 4 hpc-gfmd run scene.toml
"""

import sys

import numpy as np

import hpc_gfmd

comm = hpc_gfmd.world()  # an exception on one rank ends the whole job (sys.exit on one does not)
n = int(sys.argv[1]) if sys.argv[1:] else 1024
wall = hpc_gfmd.make_surface(
    "self-affine",
    hurst=0.8,
    L_over_lam_l=2,
    lam_l_over_lam_s=n // 8,
    lam_s_over_a=4,
    seed=1,
    g_rms=0.1,
    physical_sizes=("1 mm", "1 mm"),
)
solutions = hpc_gfmd.solve(wall, ["10 MPa", "50 MPa"], "2 GPa", comm=comm)

for solution in solutions:
    mine = solution.pressure  # rows start <= i < stop
    start, stop = solution.rows
    (largest,) = comm.max([mine.max(initial=0)])
    patches = solution.observable("patches")  # collective: all ranks ask
    print(
        f"rank {comm.rank} has rows {start} to {stop}, {np.count_nonzero(mine)} points of them"
        " touch",
        flush=True,
    )
    if comm.rank == 0:
        print(
            f"a_r = {100 * solution.a_r:.2f} %, {patches} patches, largest pressure"
            f" {largest / 1e6:.0f} MPa",
            flush=True,
        )
solutions.save("mpi_script.h5", force=True)
if comm.rank == 0:
    hpc_gfmd.load("mpi_script.h5")[0].plot().savefig("mpi_script.png")
