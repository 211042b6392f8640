"""Hostile files that must be refused: {name: (function that makes one, words of the message)}.

Other defects are found by random changes of bytes (test_readers.py).
"""

import pickle
from functools import partial

import h5py
import numpy as np
from faults.seeds import FIELD, seeds

Z = np.arange(48.0).reshape(8, 6)
HUGE = 10**6


class Trap:
    """An object that creates a file when it is unpickled."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return open, (self.path, "w")


def h5(path, fill):
    """Make an HDF5 file with fill(file), and elsewhere.h5, which no reader may open."""
    with h5py.File(path.with_name("elsewhere.h5"), "w") as file:
        file["surface"] = Z
    with h5py.File(path, "w") as file:
        fill(file)


def cut(path, data, keep):
    """Write the first part of some data."""
    path.write_bytes(data[: int(keep * len(data))])


def claims(path, shape):
    """Make a .npy file with `shape` in its header and 48 numbers."""
    with open(path, "wb") as file:
        np.lib.format.write_array_header_1_0(
            file, {"descr": "<f8", "fortran_order": False, "shape": shape}
        )
        file.write(Z.tobytes())


def trap(path):
    """Make a pickle with the name of an array."""
    path.write_bytes(pickle.dumps(Trap(path.with_name("trapped"))))


def linked(path):
    """Make a file whose map is a link to another file."""
    link = h5py.ExternalLink("elsewhere.h5", "/surface")
    h5(path, lambda file: file.update(surface=link))


def half_a_netcdf(path):
    """Make a truncated map."""
    cut(path, seeds("netcdf", path.parent)[0].read_bytes(), 0.67)


HEIGHT_MAPS = {
    "pickle as .npy": (".npy", trap, "magic string"),
    ".npy claiming 1e12 points": (".npy", partial(claims, shape=(HUGE, HUGE)), "cannot be read"),
    "empty .npy": (".npy", lambda path: path.write_bytes(b""), "empty"),
    "external link": (".h5", linked, "link to another"),
    "truncated NetCDF map": (".nc", half_a_netcdf, "netcdf"),
}


def sound(path):
    """Make a sound result file and return its bytes."""
    plain, compressed = seeds("result", path.parent)
    data = plain.read_bytes()
    plain.unlink()
    compressed.unlink()
    path.write_bytes(data)
    return data


def edit(path, change):
    """Make a sound result and change it with change(file)."""
    sound(path)
    with h5py.File(path, "r+", locking=False) as file:
        change(file)


def foreign(path):
    """Make an HDF5 file of another program."""
    with h5py.File(path, "w") as file:
        file["surface"] = Z


def one_bit(path):
    """Make a result with one bit of a number flipped."""
    data = sound(path)
    place = data.index(np.float64(0.25).tobytes()) + 3
    path.write_bytes(data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :])


def moved_out(file):
    """Move the gap to another file."""
    with h5py.File("elsewhere.h5", "w") as elsewhere:
        elsewhere["surface"] = FIELD
    del file["steps/0000/gap"]
    file["steps/0000/gap"] = h5py.ExternalLink("elsewhere.h5", "/surface")


def huge(file):
    """Replace the gap by a field of 1e6 x 1e6 points without numbers."""
    file["surface"].attrs.modify("n", [HUGE, HUGE])
    del file["steps/0000/gap"]
    file["steps/0000"].create_dataset("gap", (HUGE, HUGE), "f4")


RESULTS = {
    "truncated": (lambda path: cut(path, sound(path), 0.5), "truncated file"),
    "HDF5 of another program": (foreign, "hpc-gfmd"),
    "one bit of a number": (one_bit, "damaged"),
    "a huge field without numbers": (partial(edit, change=huge), "gap"),
    "a link out of it": (partial(edit, change=moved_out), "link"),
}
