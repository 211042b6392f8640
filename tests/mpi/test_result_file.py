"""The result file on any number of ranks: empty slabs, with and without MPI-IO, restart, errors."""

from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from result_files import HEAD

from hpc_gfmd.output import record
from hpc_gfmd.output.read import read_partial, read_result
from hpc_gfmd.output.record import RunFile
from hpc_gfmd.parallel import committed, h5
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.util.errors import GfmdError, ProgrammingError, SceneError

pytestmark = pytest.mark.mpi

SURFACE = {"n": [7, 5], "physical_sizes": [1.0, 2.0], "h_rms": 0.5}


def slab(comm, n_x, empty=()):
    """Return the rows of this rank; the ranks in `empty` own none."""
    owners = [rank for rank in range(comm.size) if rank not in empty]
    cuts = np.linspace(0, n_x, len(owners) + 1).astype(int)
    before = sum(rank < comm.rank for rank in owners)
    return int(cuts[before]), int(cuts[before + (comm.rank in owners)])


def field(n, dtype="float64"):
    return np.random.default_rng(3).random(n).astype(dtype)


def layouts(comm, n_x):
    yield slab(comm, n_x)
    if comm.size > 1:
        yield slab(comm, n_x, empty={comm.size - 1})
        yield slab(comm, n_x, empty={0})


def with_and_without_mpi(monkeypatch):
    """Run the loop body with HDF5 as it is, then as if it were built without MPI; without waiting
    for the disk."""
    for module in h5, committed, record:
        monkeypatch.setattr(module, "sync", lambda *_, **__: None)
    yield
    monkeypatch.setattr(h5py, "get_config", lambda: type("Serial", (), {"mpi": False}))
    yield


def test_round_trip(comm, shared_path, monkeypatch):
    for _ in with_and_without_mpi(monkeypatch):
        for rows in layouts(comm, 7):
            round_trip(comm, shared_path, (7, 5), rows, False, None)
        round_trip(comm, shared_path, (7, 5), rows, True, "single")
        round_trip(comm, shared_path, (3, 4), slab(comm, 3), False, None)
        round_trip(comm, shared_path, (1, 1), slab(comm, 1), True, None)


def round_trip(comm, shared_path, n, rows, compressed, dtype):
    path = shared_path / "round.h5"
    mine = slice(*rows)
    padded = field((n[0], n[1] + 3))[:, : n[1]]
    fields = {"pressure": padded, "gap": field(n[::-1], "float32").T}  # neither is contiguous
    local = {name: whole[mine] for name, whole in fields.items()}
    options = {"compressed": compressed, "dtype": dtype}
    for index in (0, 1):  # the second run resumes the first
        with RunFile(comm, path, n, rows, HEAD, SURFACE | {"n": list(n)}, **options) as run:
            assert list(run.finished) == list(range(index))
            run.update(height_field=local["gap"], setup_seconds=1.5)
            run.write_step(index, {"p_star": 0.1 * (index + 1), "status": "converged"}, local)
            assert read_partial(path).status == "running"
            comm.barrier()
            with pytest.raises(SceneError, match=r"another run is writing this file \(process \d+"):
                RunFile(comm, path, n, rows, HEAD, SURFACE)
            if index == 1:
                run.finish("converged")
        comm.barrier()
    result = read_result(path)
    assert result.status == "converged"
    assert result.scene_toml == HEAD["scene"]
    assert result.surface["n"] == list(n)
    assert [step["p_star"] for step in result.steps] == [0.1, 0.2]
    assert result.head["versions"] == '{"numpy": "2"}'
    assert result.head["setup_seconds"] == 1.5
    assert result.head["start_time"] <= result.head["end_time"]
    assert result.head["ranks"] == comm.size
    assert result.head["io"] == ("mpio" if comm.size > 1 and h5py.get_config().mpi else "serial")
    for step in result.fields:
        for name, whole in (fields | {"heights": fields["gap"]}).items():
            expected = whole.astype(dtype or whole.dtype)
            assert step[name].dtype == expected.dtype
            assert np.array_equal(step[name].read(0, n[0]), expected)
            assert np.array_equal(step[name].slab(comm, rows), expected[mine])
    with h5py.File(path, "r") as file:
        assert (file["steps/0001/gap"].compression == "gzip") == compressed
    assert not run.partial.exists()
    comm.barrier()


def test_the_same_file_on_any_number_of_ranks(comm, shared_path):
    """Groups, attributes, types, values and coordinates agree, except for times and ranks."""
    n = (7, 5)
    of_this_run = {"start_time", "end_time", "ranks", "io", "record"}
    whole = field(n)

    def write(world, path, rows):
        mine = whole[slice(*rows)]
        for compressed in (False, True):
            with RunFile(
                world, path / f"{compressed}.h5", n, rows, HEAD, SURFACE, compressed=compressed
            ) as run:
                run.update(height_field=mine)
                for index in (0, 1):
                    fields = {"gap": mine, "pressure": mine + index}
                    run.write_step(index, {"p": 0.1 + index}, fields)
                run.finish("converged")
        world.barrier()

    def content(path):
        content = {}
        with h5py.File(path, "r", locking=False) as file:
            names = ["/"]
            file.visit(names.append)
            for name in names:
                item = file[name]
                attributes = {
                    k: str(v)
                    for k, v in item.attrs.items()
                    if k not in of_this_run and "LIST" not in k
                }
                content[name] = [attributes]
                if isinstance(item, h5py.Dataset):
                    content[name] += (
                        item.dtype.str,
                        item.chunks,
                        item.compression,
                        item[()].tobytes(),
                    )
        return content

    (shared_path / f"alone-{comm.rank}").mkdir()
    write(comm, shared_path, slab(comm, 7))
    write(SerialComm(), shared_path / f"alone-{comm.rank}", (0, 7))
    for name in ("False.h5", "True.h5"):
        together = content(shared_path / name)
        by_one = content(shared_path / f"alone-{comm.rank}" / name)
        assert list(together.items()) == list(by_one.items())
        assert "steps/0001/gap" in together
        assert "VTKHDF/PointData/gap" in together


@pytest.mark.parametrize("compressed", [False, True])
def test_many_pieces(comm, shared_path, monkeypatch, compressed):
    """Slabs larger than a single write, with different numbers of writes on the ranks."""
    n = (60, 50)
    whole = field(n)
    surface = SURFACE | {"n": list(n)}
    monkeypatch.setattr(h5, "PIECE_BYTES", 7 * 50 * 8)
    rows = slab(comm, 11)
    rows = (rows[0], n[0] if rows[1] == 11 and comm.rank == comm.size - 1 else rows[1])
    for k, _ in enumerate(with_and_without_mpi(monkeypatch)):
        path = shared_path / f"pieces-{k}.h5"
        with RunFile(comm, path, n, rows, HEAD, surface, compressed=compressed) as run:
            run.write_step(0, {"p": 0.1}, {"gap": whole[slice(*rows)]})
            run.finish("converged")
        comm.barrier()
        result = read_result(path)
        assert np.array_equal(result.fields[0]["gap"].slab(comm, rows), whole[slice(*rows)])
        with RunFile(comm, shared_path / "copy.h5", n, rows, HEAD, surface, force=True) as run:
            run.take(result)
            run.finish("converged")
        comm.barrier()
        assert np.array_equal(read_result(shared_path / "copy.h5").fields[0]["gap"].read(), whole)
        comm.barrier()


def test_errors_are_agreed(comm, shared_path, monkeypatch):
    """An error on one rank is raised on all, and existing files stay as they are."""
    rows = slab(comm, 7)
    n = (7, 5)
    is_last = comm.rank == comm.size - 1
    good = field(n)[slice(*rows)]
    with pytest.raises(SceneError, match=r"folder .* does not exist"):
        RunFile(comm, shared_path / "missing" / "a.h5", n, rows, HEAD, SURFACE)
    for _ in with_and_without_mpi(monkeypatch):
        with RunFile(comm, shared_path / "agreed.h5", n, rows, HEAD, SURFACE) as run:
            run.write_step(0, {}, {"gap": good})
            with pytest.raises(GfmdError, match="points in rows"):
                run.write_step(1, {}, {"gap": good[:, :3] if is_last else good})
            fields = {"gap": SimpleNamespace(dtype=good.dtype) if is_last else good}
            mistake = TypeError if is_last else ProgrammingError
            with pytest.raises(mistake, match="not subscriptable"):
                h5.write_file(comm, run.partial / "checkpoint.h5", n, rows, fields)
            comm.barrier()
            assert sorted(p.name for p in run.partial.iterdir()) == [
                "lock",
                "result.h5",
                "result.h5.committed",
            ]
            assert read_partial(run.path).indices == [0]
        comm.barrier()
