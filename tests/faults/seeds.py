"""Small valid files of every kind, from which fuzzing starts."""

import io
import json
from pathlib import Path

import h5py
import numpy as np
import result_files
from result_files import FIELD, SCENE, N, begin
from scipy.io import netcdf_file

from hpc_gfmd.output.read import CHECKPOINT
from hpc_gfmd.theory import tfc

SURFACE = result_files.SURFACE | {"kind": "wave", "seed": -1, "eps_t": 0.5}
STEP = result_files.STEP | {"gap_mean": 0.1}


def seeds(target, folder):
    """Make the seeds of a target in a folder and return their paths."""
    return _MAKERS[target](Path(folder))


def _scenes(folder):
    texts = [path.read_text() for path in sorted(SCENE.parent.glob("*.toml"))]
    return [_put(folder / f"{i}.toml", text.encode()) for i, text in enumerate(texts)]


def _npy(folder):
    arrays = [
        FIELD,
        FIELD.astype(">f4"),
        np.asfortranarray(FIELD.astype("i2")),
        np.zeros((0, 3)),
        FIELD[0],
        FIELD + 1j,
    ]
    paths = []
    for i, array in enumerate(arrays):
        memory = io.BytesIO()
        np.save(memory, array)
        paths.append(_put(folder / f"{i}.npy", memory.getvalue()))
    return paths


def _hdf5(folder):
    paths = [folder / "plain.h5", folder / "packed.h5", folder / "new.h5"]
    with h5py.File(paths[0], "w") as file:
        file["surface"] = FIELD
        file["surface"].attrs["unit"] = "m"
        file["link"] = h5py.SoftLink("/surface")
    with h5py.File(paths[1], "w") as file:
        file.create_dataset(
            "surface",
            data=FIELD.astype("i2"),
            chunks=(2, 3),
            compression="gzip",
            shuffle=True,
            fletcher32=True,
        )
    with h5py.File(paths[2], "w", libver="v110") as file:
        file.create_dataset(
            "surface", data=FIELD.astype(">f4"), chunks=(3, 5), maxshape=(None, 5), scaleoffset=None
        )
    return paths


def _netcdf(folder):
    paths = [folder / "two.nc", folder / "records.nc"]
    for path, record in zip(paths, (False, True)):
        with netcdf_file(path, "w") as file:
            file.createDimension("x", None if record else N[0])
            file.createDimension("y", N[1])
            z = file.createVariable("z", "f4" if record else "i2", ("x", "y"))
            z[:] = FIELD
            z.units = "m"
            z.scale_factor = 0.5
    return paths + [p.rename(p.with_suffix(".nc")) for p in _hdf5(folder)[:1]]


def _results(folder):
    paths = []
    for name, compressed in (("result", False), ("compressed", True)):
        paths.append(folder / f"{name}.h5")
        with begin(paths[-1], surface=SURFACE, compressed=compressed) as run:
            for index, status in enumerate(("converged", "stagnated")):
                run.write_step(index, STEP | {"status": status}, {"gap": FIELD})
            run.finish("stagnated")
    return paths


def _checkpoints(folder):
    with begin(folder / "out.h5", surface=SURFACE) as run:
        run.write_state(CHECKPOINT, 0, {"gap": FIELD}, result_files.UNFINISHED)
    return [run.partial / "checkpoint.h5"]


def _coefficients(folder):
    return [_put(folder / "table.json", json.dumps(tfc.paper_table()).encode())]


def _put(path, data):
    path.write_bytes(data)
    return path


_MAKERS = {
    "scene": _scenes,
    "npy": _npy,
    "hdf5": _hdf5,
    "netcdf": _netcdf,
    "result": _results,
    "checkpoint": _checkpoints,
    "coefficients": _coefficients,
}
