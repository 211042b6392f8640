"""The result file on any number of ranks: empty slabs, every transport, restart, agreed errors."""

import shutil

import numpy as np
import pytest

from hpc_gfmd.errors import GfmdError, SceneError
from hpc_gfmd.output.read import read_partial, read_result
from hpc_gfmd.output.record import RunFile
from hpc_gfmd.parallel import h5, h5_fill

pytestmark = pytest.mark.mpi

HEAD = {"scene": "title = 'x'", "identity": "abc", "versions": {"numpy": "2"}}
SURFACE = {"n": [7, 5], "h_rms": 0.5}


def slab(comm, n_x, empty=()):
    """Rows of this rank; the ranks in `empty` own none."""
    owners = [rank for rank in range(comm.size) if rank not in empty]
    cuts = np.linspace(0, n_x, len(owners) + 1).astype(int)
    start, stop = 0, 0
    for rank in range(comm.rank + 1):
        if rank in owners:
            start, stop = cuts[owners.index(rank)], cuts[owners.index(rank) + 1]
        else:
            start = stop
    return int(start), int(stop)


def field(n, dtype="float64"):
    return np.random.default_rng(3).random(n).astype(dtype)


def layouts(comm, n_x):
    yield slab(comm, n_x)
    if comm.size > 1:
        yield slab(comm, n_x, empty={comm.size - 1})
        yield slab(comm, n_x, empty={0})


def transports(comm):
    import h5py

    return ("direct", "root", "mpio") if comm.size > 1 and h5py.get_config().mpi else ("direct", "root")


def test_round_trip(comm, shared_path):
    for transport in transports(comm):
        for rows in layouts(comm, 7):
            round_trip(comm, shared_path, (7, 5), rows, transport, False, None)
        round_trip(comm, shared_path, (7, 5), rows, transport, True, "single")
        round_trip(comm, shared_path, (3, 4), slab(comm, 3), transport, False, None)
        round_trip(comm, shared_path, (1, 1), slab(comm, 1), transport, True, None)


def round_trip(comm, shared_path, n, rows, transport, compressed, dtype):
    path = shared_path / "round.h5"
    fields = {"pressure": field(n), "gap": field(n, "float32")}
    how = {"transport": transport, "compressed": compressed, "dtype": dtype}
    local = {name: whole[slice(*rows)] for name, whole in fields.items()}
    with RunFile(comm, path, n, rows, HEAD, SURFACE | {"n": list(n)}, **how) as run:
        for index in (0, 1):
            run.write_step(index, {"p_star": 0.1 * (index + 1), "status": "converged"}, local)
        run.finish("converged", setup_seconds=1.5)
    result = read_result(path)
    assert (result.status, result.scene_toml, result.surface["n"]) == ("converged", HEAD["scene"], list(n))
    assert [step["p_star"] for step in result.steps] == [0.1, 0.2]
    assert result.versions == {"numpy": "2"}
    assert result.head["setup_seconds"] == 1.5
    assert result.head["ranks"] == comm.size
    for step in result.fields:
        for name, whole in fields.items():
            stored = step[name]
            assert stored.stored == np.dtype(dtype or whole.dtype)
            assert stored.compressed == compressed
            assert np.array_equal(stored.read(*rows), whole[slice(*rows)].astype(stored.stored))
            assert np.array_equal(stored.read(0, n[0]), whole.astype(stored.stored))
    assert not run.partial.exists()
    comm.barrier()


def test_many_pieces(comm, shared_path):
    """Slabs larger than one call may write, with a different number of calls on every rank."""
    n, whole = (60, 50), field((60, 50))
    path = shared_path / "pieces.h5"
    before, h5_fill.PIECE_BYTES = h5_fill.PIECE_BYTES, 7 * 50 * 8
    try:
        for transport in transports(comm):
            for compressed in (False, True):
                rows = slab(comm, 11)
                rows = (rows[0], n[0] if rows[1] == 11 and comm.rank == comm.size - 1 else rows[1])
                part = h5.Slab(whole[slice(*rows)], rows[0], n)
                h5.write_file(comm, path, {}, {"a/b": part}, transport=transport, compressed=compressed)
                assert np.array_equal(h5.read_rows(path, "a/b", (0, 60)), whole)
                comm.barrier()
    finally:
        h5_fill.PIECE_BYTES = before


def test_not_contiguous(comm, shared_path):
    """Views with padded rows, transposed and complex arrays, as states of solvers are."""
    rows, path = slab(comm, 7), shared_path / "views.h5"
    padded, turned = field((7, 8)), field((5, 7)).T
    spectrum = field((7, 5)) + 1j
    for transport in transports(comm):
        fields = {
            "padded": h5.Slab(padded[slice(*rows), :5], rows[0], (7, 5)),
            "turned": h5.Slab(turned[slice(*rows)], rows[0], (7, 5)),
            "spectrum": h5.Slab(spectrum[slice(*rows)], rows[0], (7, 5)),
        }
        h5.write_file(comm, path, {"state": {"dt": 0.5}}, fields, transport=transport)
        for name, whole in (("padded", padded[:, :5]), ("turned", turned), ("spectrum", spectrum)):
            assert np.array_equal(h5.read_rows(path, name, rows), whole[slice(*rows)])
        comm.barrier()


def test_resume(comm, shared_path):
    path, rows, n = shared_path / "resume.h5", slab(comm, 7), (7, 5)
    whole = field(n)
    run = RunFile(comm, path, n, rows, HEAD, SURFACE)
    run.write_step(0, {"status": "converged"}, {"gap": whole[slice(*rows)]})
    run.write_step(1, {"status": "interrupted"}, {"gap": whole[slice(*rows)]})
    run.close()
    comm.barrier()
    assert read_result(path).status == "interrupted"
    comm.barrier()
    with pytest.raises(SceneError, match="another scene"):
        RunFile(comm, path, n, rows, HEAD | {"identity": "other"}, SURFACE, resume=True)
    rows = slab(comm, 7, empty={0} if comm.size > 1 else ())
    run = RunFile(comm, path, n, rows, HEAD, SURFACE, resume=True)
    assert run.finished == [0]
    run.write_step(1, {"status": "converged"}, {"gap": whole[slice(*rows)]})
    run.finish("converged")
    result = read_result(path)
    assert [step["status"] for step in result.steps] == ["converged", "converged"]
    assert np.array_equal(result.fields[1]["gap"].read(0, 7), whole)
    comm.barrier()


def test_locked(comm, shared_path):
    path, rows = shared_path / "locked.h5", slab(comm, 7)
    with RunFile(comm, path, (7, 5), rows, HEAD, SURFACE):
        assert read_partial(path).status == "running"
        comm.barrier()
        with pytest.raises(SceneError, match="another run is writing this file"):
            RunFile(comm, path, (7, 5), rows, HEAD, SURFACE)
    comm.barrier()


def test_errors_are_agreed(comm, shared_path):
    """What fails on one rank fails on all, and what was there before is untouched."""
    rows, n, last = slab(comm, 7), (7, 5), comm.rank == comm.size - 1
    good = field(n)[slice(*rows)]
    with pytest.raises(SceneError, match=r"folder .* does not exist"):
        RunFile(comm, shared_path / "missing" / "a.h5", n, rows, HEAD, SURFACE)
    for transport in transports(comm):
        with RunFile(comm, shared_path / "agreed.h5", n, rows, HEAD, SURFACE, transport=transport) as run:
            run.write_step(0, {}, {"gap": good})
            with pytest.raises(GfmdError, match="local shape"):
                run.write_step(1, {}, {"gap": good[:, :3] if last else good})
            if comm.size > 1:
                with pytest.raises(GfmdError, match="disagree"):
                    run.write_step(1, {}, {"gap" if last else "height": good})
            fields = {"gap": Broken(good, rows[0], n) if last else h5.Slab(good, rows[0], n)}
            with pytest.raises(GfmdError, match="no such number"):
                h5.write_file(comm, run.partial / "step-0001.h5", {}, fields, transport=transport)
            comm.barrier()
            assert sorted(p.name for p in run.partial.iterdir()) == ["head.h5", "lock", "step-0000.h5"]
            comm.barrier()
            if comm.rank == 0:
                shutil.rmtree(run.partial)
            comm.barrier()
            with pytest.raises(GfmdError, match="No such file"):
                run.write_step(1, {}, {"gap": good})


class Broken(h5.Slab):
    def read(self, start, stop):
        raise ValueError("no such number")
