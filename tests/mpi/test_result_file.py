"""The result file on any number of ranks: empty slabs, MPI-IO or not, restart, agreed errors."""

import os
import shutil

import h5py
import numpy as np
import pytest

from hpc_gfmd.output.read import read_partial, read_result
from hpc_gfmd.output.record import RunFile
from hpc_gfmd.parallel import h5
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.util.errors import GfmdError, SceneError

pytestmark = pytest.mark.mpi

HEAD = {"scene": "title = 'x'", "identity": "abc", "versions": {"numpy": "2"}}
SURFACE = {"n": [7, 5], "physical_sizes": [1.0, 2.0], "h_rms": 0.5}


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


def with_and_without_mpi(monkeypatch):
    """HDF5 as it is, then one that says it was built without MPI."""
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
    fields = {"pressure": field(n), "gap": field(n, "float32")}
    local = {name: whole[slice(*rows)] for name, whole in fields.items()}
    with RunFile(
        comm, path, n, rows, HEAD, SURFACE | {"n": list(n)}, compressed=compressed, dtype=dtype
    ) as run:
        run.update(height_field=local["gap"])
        for index in (0, 1):
            run.write_step(index, {"p_star": 0.1 * (index + 1), "status": "converged"}, local)
        run.finish("converged", setup_seconds=1.5)
    result = read_result(path)
    assert (result.status, result.scene_toml, result.surface["n"]) == (
        "converged",
        HEAD["scene"],
        list(n),
    )
    assert [step["p_star"] for step in result.steps] == [0.1, 0.2]
    assert result.head["versions"] == '{"numpy": "2"}'
    assert result.head["setup_seconds"] == 1.5
    assert result.head["ranks"] == comm.size
    assert result.head["io"] == ("mpio" if comm.size > 1 and h5py.get_config().mpi else "serial")
    for step in result.fields:
        for name, whole in (fields | {"heights": fields["gap"]}).items():
            stored = step[name]
            assert stored.dtype == np.dtype(dtype or whole.dtype)
            assert np.array_equal(stored.read(0, n[0]), whole.astype(stored.dtype))
            assert np.array_equal(stored.slab(comm, rows), whole[slice(*rows)].astype(stored.dtype))
    with h5py.File(path, "r") as file:
        assert (file["steps/0001/gap"].compression == "gzip") == compressed
    assert not run.partial.exists()
    comm.barrier()


def test_the_same_file_on_any_number_of_ranks(comm, shared_path):
    """Groups, attributes, types, values and coordinates; but for times and who wrote it."""
    n, own = (7, 5), {"start_time", "end_time", "ranks", "io", "record"}
    whole = field(n)

    def write(world, path, rows):
        for compressed in (False, True):
            with RunFile(
                world, path / f"{compressed}.h5", n, rows, HEAD, SURFACE, compressed=compressed
            ) as run:
                run.update(height_field=whole[slice(*rows)])
                for index in (0, 1):
                    run.write_step(
                        index,
                        {"p": 0.1 + index},
                        {"gap": whole[slice(*rows)], "pressure": whole[slice(*rows)] + index},
                    )
                run.finish("converged")
        world.barrier()

    def content(path):
        found = {}
        with h5py.File(path, "r", locking=False) as file:
            names = ["/"]
            file.visit(names.append)
            for name in names:
                item = file[name]
                attributes = {
                    k: str(v) for k, v in item.attrs.items() if k not in own and "LIST" not in k
                }
                is_data = isinstance(item, h5py.Dataset)
                found[name] = (
                    attributes,
                    (item.dtype.str, item.chunks, item.compression, item[()].tobytes())
                    if is_data
                    else None,
                )
        return found

    (shared_path / f"alone-{comm.rank}").mkdir()
    write(comm, shared_path, slab(comm, 7))
    write(SerialComm(), shared_path / f"alone-{comm.rank}", (0, 7))
    for name in ("False.h5", "True.h5"):
        together, by_one = (
            content(shared_path / name),
            content(shared_path / f"alone-{comm.rank}" / name),
        )
        assert list(together) == list(by_one)
        assert together == by_one
        assert "steps/0001/gap" in together
        assert "VTKHDF/PointData/gap" in together


def test_several_ranks_write_and_read_by_mpi_io(comm, shared_path, monkeypatch):
    """The driver that HDF5 itself names, and the transfers that were collective."""
    drivers, collective, create, rows = [], [], h5py.h5p.create, slab(comm, 7)

    class Spy(h5py.File):
        def __init__(self, name, mode="r", **how):
            super().__init__(name, mode, **how)
            if comm.size == 1 or "comm" in how:
                drivers.append(
                    (mode, self.driver, self.id.get_access_plist().get_driver() == h5py.h5fd.MPIO)
                )

    def spy(kind):
        found = create(kind)
        if kind is h5py.h5p.DATASET_XFER:
            collective.append(found)
        return found

    monkeypatch.setattr(h5py, "File", Spy)
    monkeypatch.setattr(h5py.h5p, "create", spy)
    whole = field((7, 5))
    h5.write_file(comm, shared_path / "a.h5", (7, 5), rows, {"u": whole[slice(*rows)]})
    if comm.size > 1:
        assert drivers == [("r+", "mpio", True)]
    stored = h5.Stored(
        shared_path / "a.h5", "u", (7, 5), whole.dtype, checksum(shared_path / "a.h5", "u")
    )
    drivers.clear()
    stored.slab(comm, rows)
    if comm.size > 1:
        assert drivers == [("r", "mpio", True)]
        assert [found.get_dxpl_mpio() for found in collective].count(h5py.h5fd.MPIO_COLLECTIVE) == 2
    else:
        assert not any(mpio for *_, mpio in drivers)


def test_the_disk_is_busy_while_the_next_piece_is_made(comm, shared_path, monkeypatch):
    """The system is told to write what is there after each piece, not after the last one alone."""
    told, advise, fsync, rows = [], os.posix_fadvise, os.fsync, slab(comm, 60)
    monkeypatch.setattr(h5, "PIECE_BYTES", 7 * 50 * 8)
    monkeypatch.setattr(os, "posix_fadvise", lambda *args: told.append(args[1:]) or advise(*args))
    monkeypatch.setattr(os, "fsync", lambda file: told.append("sync") or fsync(file))
    h5.write_file(comm, shared_path / "a.h5", (60, 50), rows, {"u": field((60, 50))[slice(*rows)]})
    if comm.size == 1 or h5.io_way(comm) == "mpio":
        pieces = told.index("sync")
        assert pieces == -(-(60 // comm.size) // 7)
        assert set(told[:pieces]) == {(0, 0, os.POSIX_FADV_DONTNEED)}


def numbers(path, name):
    with h5py.File(path, "r", locking=False) as file:
        return file[name][:]


def checksum(path, name):
    with h5py.File(path, "r", locking=False) as file:
        return int(file[name].attrs["checksum"])


def test_many_pieces(comm, shared_path, monkeypatch):
    """Slabs larger than one call may write, with a different number of calls on every rank."""
    n, whole = (60, 50), field((60, 50))
    path = shared_path / "pieces.h5"
    monkeypatch.setattr(h5, "PIECE_BYTES", 7 * 50 * 8)
    rows = slab(comm, 11)
    rows = (rows[0], n[0] if rows[1] == 11 and comm.rank == comm.size - 1 else rows[1])
    found = set()
    for _ in with_and_without_mpi(monkeypatch):
        for compressed in (False, True):
            h5.write_file(comm, path, n, rows, {"a/b": whole[slice(*rows)]}, compressed=compressed)
            assert np.array_equal(numbers(path, "a/b"), whole)
            found.add(checksum(path, "a/b"))
            comm.barrier()
    h5.write_file(
        comm, path, n, rows, {"c": h5.Stored(path, "a/b", n, whole.dtype, *found)}
    )  # a copy of itself, by all ranks
    assert np.array_equal(numbers(path, "c"), whole)
    monkeypatch.setattr(h5, "PIECE_BYTES", 2**26)
    h5.write_file(SerialComm(), shared_path / f"alone-{comm.rank}.h5", n, (0, 60), {"a/b": whole})
    assert found == {
        checksum(shared_path / f"alone-{comm.rank}.h5", "a/b")
    }  # whatever the ranks and pieces


def test_damage_on_one_rank_stops_all(comm, shared_path):
    """In the numbers of the last rows, as they are or packed."""
    whole, rows, path = field((40, 30)), slab(comm, 40), shared_path / "damaged.h5"
    for compressed in (False, True):
        h5.write_file(comm, path, (40, 30), rows, {"u": whole[slice(*rows)]}, compressed=compressed)
        stored = h5.Stored(path, "u", (40, 30), whole.dtype, checksum(path, "u"))
        assert np.array_equal(stored.slab(comm, rows), whole[slice(*rows)])
        comm.barrier()
        if comm.rank == 0:
            with h5py.File(path) as file:
                data = file["u"].id
                place = (
                    data.get_chunk_info_by_coord((39, 0)).byte_offset + 20
                    if compressed
                    else data.get_offset() + 39 * 30 * 8
                )
            content = bytearray(path.read_bytes())
            content[place] ^= 1
            path.write_bytes(content)
        comm.barrier()
        with pytest.raises(
            GfmdError, match="inflate" if compressed else "the numbers of u are damaged"
        ):
            stored.slab(comm, rows)
        comm.barrier()


def test_memory_that_one_rank_lacks_stops_all(comm, shared_path, monkeypatch):
    """No rank waits in a collective read for the one that cannot take part."""
    whole, rows, path = field((40, 30)), slab(comm, 40), shared_path / "scarce.h5"
    h5.write_file(comm, path, (40, 30), rows, {"u": whole[slice(*rows)]})
    stored, calls = h5.Stored(path, "u", (40, 30), whole.dtype, checksum(path, "u")), []

    class Scarce:
        def __getattr__(self, name):
            return getattr(np, name)

        def empty(self, *args):
            calls.append(args)
            if len(calls) == 2:  # the first is for all of the slab
                raise MemoryError("Unable to allocate 64 MiB")
            return np.empty(*args)

    if comm.rank == comm.size - 1:
        monkeypatch.setattr(h5, "np", Scarce())
    with pytest.raises(GfmdError, match=r"reading .*scarce\.h5: out of memory"):
        stored.slab(comm, rows)


def test_not_contiguous(comm, shared_path, monkeypatch):
    """Views with padded rows, transposed and complex arrays, as states of solvers are."""
    rows, path = slab(comm, 7), shared_path / "views.h5"
    padded, turned = field((7, 8)), field((5, 7)).T
    spectrum = field((7, 5)) + 1j
    for _ in with_and_without_mpi(monkeypatch):
        fields = {
            "padded": padded[slice(*rows), :5],
            "turned": turned[slice(*rows)],
            "spectrum": spectrum[slice(*rows)],
        }
        h5.write_file(comm, path, (7, 5), rows, fields)
        for name, whole in (("padded", padded[:, :5]), ("turned", turned), ("spectrum", spectrum)):
            assert np.array_equal(numbers(path, name)[slice(*rows)], whole[slice(*rows)])
        comm.barrier()


def test_resume(comm, shared_path):
    path, rows, n = shared_path / "resume.h5", slab(comm, 7), (7, 5)
    whole = field(n)
    run = RunFile(comm, path, n, rows, HEAD, SURFACE)
    run.write_step(0, {"status": "converged"}, {"gap": whole[slice(*rows)]})
    run.close()
    comm.barrier()
    assert read_result(path).status == "interrupted"
    comm.barrier()
    with pytest.raises(SceneError, match="another scene"):
        RunFile(comm, path, n, rows, HEAD | {"identity": "other"}, SURFACE)
    rows = slab(comm, 7, empty={0} if comm.size > 1 else ())
    run = RunFile(comm, path, n, rows, HEAD, SURFACE)
    assert list(run.finished) == [0]
    run.write_step(1, {"status": "converged"}, {"gap": whole[slice(*rows)]})
    run.finish("converged")
    result = read_result(path)
    assert [step["status"] for step in result.steps] == ["converged", "converged"]
    assert np.array_equal(result.fields[1]["gap"].read(0, 7), whole)


def test_locked(comm, shared_path):
    path, rows = shared_path / "locked.h5", slab(comm, 7)
    with RunFile(comm, path, (7, 5), rows, HEAD, SURFACE):
        assert read_partial(path).status == "running"
        comm.barrier()
        with pytest.raises(SceneError, match="another run is writing this file"):
            RunFile(comm, path, (7, 5), rows, HEAD, SURFACE)


def test_errors_are_agreed(comm, shared_path, monkeypatch):
    """What fails on one rank fails on all, and what was there before is untouched."""
    rows, n, last = slab(comm, 7), (7, 5), comm.rank == comm.size - 1
    good = field(n)[slice(*rows)]
    with pytest.raises(SceneError, match=r"folder .* does not exist"):
        RunFile(comm, shared_path / "missing" / "a.h5", n, rows, HEAD, SURFACE)
    for _ in with_and_without_mpi(monkeypatch):
        with RunFile(comm, shared_path / "agreed.h5", n, rows, HEAD, SURFACE) as run:
            run.write_step(0, {}, {"gap": good})
            with pytest.raises(GfmdError, match="points in rows"):
                run.write_step(1, {}, {"gap": good[:, :3] if last else good})
            fields = {"gap": Broken(good) if last else good}
            with pytest.raises(GfmdError, match="no such number"):
                h5.write_file(comm, run.partial / "step-0001.h5", n, rows, fields)
            comm.barrier()
            assert sorted(p.name for p in run.partial.iterdir()) == [
                "head.h5",
                "lock",
                "step-0000.h5",
            ]
            comm.barrier()
            if comm.rank == 0:
                shutil.rmtree(run.partial)
            comm.barrier()
            with pytest.raises(GfmdError, match="No such file"):
                run.write_step(1, {}, {"gap": good})
        comm.barrier()


class Broken:
    """A local slab whose numbers cannot be computed."""

    def __init__(self, data):
        self.shape, self.dtype = data.shape, data.dtype

    def __len__(self):
        return self.shape[0]

    def __getitem__(self, rows):
        raise ValueError("no such number")
