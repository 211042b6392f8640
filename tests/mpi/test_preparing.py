"""Height maps on several ranks: prepared on one and scattered, or read by rows on each."""

from itertools import product

import numpy as np
import pytest
from contacts import random_heights
from mpi.same import from_rank_0, save

import hpc_gfmd
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.scene import File, Scene
from hpc_gfmd.surface import build_surface, topography
from hpc_gfmd.util.errors import SceneError

pytestmark = pytest.mark.mpi
SIZES = (2.0, 1.0)


def checksum_in_one_process(comm, spec):
    """Return the checksum of the heights that rank 0 makes alone."""
    return from_rank_0(comm, lambda: build_surface(spec, SerialComm(), np.float64).checksum)


ALL = {"crop": (0, 0, 1, 1), "detrend": "curvature", "flip": True, "downsample": 2}


@pytest.mark.parametrize(
    ("boundary", "keys"),
    [
        *product(("periodic", "free", ("free", "periodic")), ({"refine": 2}, {"downsample": 2})),
        ("mirror", ALL),
        (("periodic", "mirror"), {"downsample": 2}),
        ("free", {"detrend": "tilt", "radius": 9.0, "refine": 2}),
    ],
)
def test_the_same_heights_on_any_number_of_ranks(boundary, keys, comm):
    """Heights agree to the bit."""
    keys = keys | {"boundary": boundary, "fill": "harmonic", "physical_sizes": SIZES}
    spec = File(kind="file", path="z.npy", **keys)
    for n in ((6, 8), (2, 16), (34, 20)):
        z = random_heights(n) + 1e-2 * np.arange(n[1])
        z[4:9, 3:5] = np.nan
        save(comm, z=z)
        together = build_surface(spec, comm, np.float64)
        assert together.checksum == checksum_in_one_process(comm, spec)
        comm.barrier()
    assert "crop" not in keys or together.prepared == (
        "cropped to 17 x 20 points",
        "curvature removed",
        "10 points (2.9 %) filled",
        "upside down",
        "mirrored",
        "resampled to 17 x 20 points",
    )


def test_a_map_that_needs_no_preparation_is_read_by_rows(comm):
    """On each rank from an array in a file, by rank 0 from a text: the same heights, and holes are
    refused in the same words."""
    z = random_heights((17, 12))
    holes = z.copy()
    holes[15, 3] = np.nan
    if comm.rank == 0:
        np.savetxt("z.txt", z)
        np.savetxt("holes.txt", holes)
    save(comm, z=z, holes=holes)
    keys = {"kind": "file", "boundary": "free", "physical_sizes": SIZES, "radius": 9.0}
    checksums = [
        build_surface(File(path=f"z.{suffix}", **keys), comm, np.float64).checksum
        for suffix in ("npy", "txt")
    ]
    assert len(set(checksums)) == 1
    for suffix in ("npy", "txt"):
        with pytest.raises(SceneError, match=r"found nan at \(15, 3\) in .*1 points without"):
            build_surface(File(path=f"holes.{suffix}", **keys), comm, np.float64)


def test_a_text_is_opened_once_by_all_ranks_of_a_run(comm, monkeypatch):
    opened = []
    original = topography.open_map
    monkeypatch.setattr(topography, "open_map", lambda spec: opened.append(1) or original(spec))
    if comm.rank == 0:
        np.savetxt("z.txt", random_heights((24, 20)))
    comm.barrier()
    surface = {"kind": "file", "path": "z.txt", "physical_sizes": SIZES, "boundary": "mirror"}
    tables = {"load": {"p_star": [0.05, 0.1]}, "solver": {"precision": "single"}}
    scene = Scene.from_dict(tables | {"surface": surface})
    hpc_gfmd.run(scene, out="z.h5", quiet=True, comm=comm.mpi)
    assert len(opened) == (comm.rank == 0)


@pytest.mark.parametrize("boundary", ["free", "periodic", ("free", "periodic")])
def test_two_scans_are_the_same_on_any_number_of_ranks(boundary, comm):
    fine = random_heights((37, 22), seed=1)
    coarse = random_heights((13, 9), seed=2)
    coarse[4:6, 3] = np.nan
    save(comm, fine=fine, coarse=coarse)
    bodies = ("fine.npy", {"path": "coarse.npy", "shift": (-0.3, 0.1)})
    keys = {"fill": "harmonic", "detrend": "tilt", "boundary": boundary, "physical_sizes": SIZES}
    spec = File(kind="file", bodies=bodies, **keys)
    together = build_surface(spec, comm, np.float64)
    assert together.checksum == checksum_in_one_process(comm, spec)
    assert any("coarse.npy interpolated" in line for line in together.prepared)
    comm.barrier()


def test_different_files_on_ranks(comm):
    path = f"{comm.rank}.npy"
    np.save(path, np.zeros((4 + comm.rank, 4)))
    if comm.size > 1:
        with pytest.raises(SceneError, match="on some ranks"):
            build_surface(File(kind="file", path=path, physical_sizes=SIZES), comm, np.float64)
