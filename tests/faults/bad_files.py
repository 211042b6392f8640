"""Height maps and result files that must be refused: {how they are made: ([extension,]
function(path), words of the message)}."""

import os
import pickle
import zipfile
from functools import partial
from pathlib import Path

import h5py
import numpy as np
from faults.seeds import FIELD, seeds
from faults.structured import put

from hpc_gfmd.output.read import FORMAT_VERSION
from hpc_gfmd.parallel.h5 import CHECKSUM

Z = np.arange(48.0).reshape(8, 6)


class Trap:
    """Unpickled, it makes a file."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return open, (self.path, "w")


def claims(path, shape):
    """A .npy file whose header promises `shape` and that holds 48 numbers."""
    with open(path, "wb") as file:
        np.lib.format.write_array_header_1_0(
            file, {"descr": "<f8", "fortran_order": False, "shape": shape}
        )
        file.write(Z.tobytes())


def h5(path, fill):
    """An HDF5 file that fill(file) fills; beside it one that no map may reach."""
    with h5py.File(path.with_name("elsewhere.h5"), "w") as file:
        file["surface"] = Z
    with h5py.File(path, "w") as file:
        fill(file)


def soft_way_out(file):
    """A soft link whose target is reached through another file."""
    file["out"] = h5py.ExternalLink("elsewhere.h5", "/")
    file["surface"] = h5py.SoftLink("/out/surface")


def cut(path, data, keep):
    """The first part of a file."""
    path.write_bytes(data[: int(keep * len(data))])


def garbled(path, data):
    """256 random bytes in its middle."""
    middle = len(data) // 2
    noise = np.random.default_rng(0).bytes(256)
    path.write_bytes(data[:middle] + noise + data[middle + 256 :])


def saved(path, array):
    """By numpy.save, pickled where that needs it."""
    np.save(path, array, allow_pickle=True)


def raw_h5(path, array=Z, **how):
    """A sound height map in HDF5, as bytes."""
    with h5py.File(path, "w") as file:
        file.create_dataset("surface", data=array, **how)
    return path.read_bytes()


def classic(path):
    """A sound height map in NetCDF, as bytes."""
    return seeds("netcdf", path.parent)[0].read_bytes()


def archive(path, **shapes):
    """A .npz of arrays that claim these shapes, and have no numbers."""
    with zipfile.ZipFile(path, "w") as file:
        for name, shape in shapes.items():
            with file.open(f"{name}.npy", "w") as array:
                np.lib.format.write_array_header_1_0(
                    array, {"descr": "<f8", "fortran_order": False, "shape": shape}
                )


def with_value(value):
    """The map with one point of this height."""
    z = Z.copy()
    z[7, 5] = value
    return z


ARRAYS = {  # that are no heights
    "Python objects": lambda: np.array([Trap(Path("trapped"))], dtype=object),
    "complex128": lambda: Z + 1j,
    "allowed: a real array": lambda: Z.astype(str),
    "found nan at (7, 5)": lambda: with_value(np.nan),
    "found -inf at (7, 5)": lambda: with_value(-np.inf),
    "found 1.7e+308 at (7, 5)": lambda: with_value(1.7e308),
    "inf": lambda: with_value(1).astype("g") * np.longdouble("1e400"),
    "two axes": lambda: Z.ravel(),
    "not empty": lambda: Z[:0],
}
MAPS_IN_HDF5 = {  # what is in the file
    "missing data set": (lambda f: f.create_group("surface"), "surface.dataset"),
    "external link": (lambda f: put(f, "surface", "external link"), "link to another"),
    "soft link out of the file": (soft_way_out, "link to another file"),
    "links in a circle": (lambda f: f.update(surface=h5py.SoftLink("/surface")), "too many links"),
    "link to a device": (
        lambda f: f.update(surface=h5py.ExternalLink("/dev/zero", "/x")),
        "unable to open external",
    ),
    "virtual data set": (lambda f: put(f, "surface", "virtual"), "lie in another file"),
    "external data set": (lambda f: put(f, "surface", "external"), "lie in another file"),
    "HDF5 map of 2^62 points": (lambda f: put(f, "surface", "huge"), "GiB"),
}
HEIGHT_MAPS = {
    **{
        f"of {words}": (".npy", lambda p, make=make: saved(p, make()), words)
        for words, make in ARRAYS.items()
    },
    "pickle as .npy": (
        ".npy",
        lambda p: p.write_bytes(pickle.dumps(Trap(p.with_name("trapped")))),
        "the magic string is not correct",
    ),
    ".npy claiming 1e12 points": (".npy", lambda p: claims(p, (10**6, 10**6)), "cannot be read"),
    ".npy claiming negative size": (".npy", lambda p: claims(p, (-8, 6)), "npy"),
    "truncated .npy": (
        ".npy",
        lambda p: (saved(p, Z), cut(p, p.read_bytes(), 0.67)),
        "cannot be read",
    ),
    "empty .npy": (".npy", lambda p: p.write_bytes(b""), "cannot be read"),
    "folder as height map": (".npy", lambda p: p.mkdir(), "no file"),
    "foreign HDF5 map": (".h5", lambda p: p.write_text("hello"), "cannot be read as hdf5"),
    "truncated HDF5 map": (".h5", lambda p: cut(p, raw_h5(p), 0.67), "z.h5"),
    "garbled HDF5 map": (
        ".h5",
        lambda p: garbled(
            p, raw_h5(p, np.random.default_rng(1).random((64, 64)), compression="gzip")
        ),
        "z.h5",
    ),
    **{
        name: (".h5", partial(h5, fill=fill), words) for name, (fill, words) in MAPS_IN_HDF5.items()
    },
    ".npz claiming 1e12 points": (".npz", lambda p: archive(p, surface=(10**6, 10**6)), "shorter"),
    "truncated NetCDF map": (".nc", lambda p: cut(p, classic(p), 0.67), "cannot be read as netcdf"),
    "foreign NetCDF map": (".nc", lambda p: p.write_text("hello"), "cannot be read as netcdf"),
}


def sound(path):
    """A sound result file, as bytes."""
    made, other = seeds("result", path.parent)
    data = made.read_bytes()
    made.unlink()
    other.unlink()
    path.write_bytes(data)
    return data


def edit(path, change):
    """A sound result, changed by h5py."""
    sound(path)
    with h5py.File(path, "r+", locking=False) as file:
        change(file)


def one_bit(path, data, number):
    """One bit of a number, or of a text, flipped."""
    place = data.index(number) + 3
    path.write_bytes(data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :])


def moved_out(file):
    """The gap in another file."""
    with h5py.File("elsewhere.h5", "w") as other:
        other["surface"] = FIELD
    del file["steps/0000/gap"]
    file["steps/0000/gap"] = h5py.ExternalLink("elsewhere.h5", "/surface")


def of_another_size(file):
    """A field that does not fit the surface."""
    file["steps/0000"].create_dataset("pressure", data=FIELD.T)


HUGE = 10**6


def huge(file, **how):
    """A field of 1e6 x 1e6 points, as the surface says, of which at most one row is there."""
    file["surface"].attrs.modify("n", [HUGE, HUGE])
    checksum = file["steps/0000/gap"].attrs[CHECKSUM]
    del file["steps/0000/gap"]
    gap = file["steps/0000"].create_dataset("gap", (HUGE, HUGE), "f4", **how)
    gap.attrs[CHECKSUM] = checksum
    if how:
        gap[0] = 1.0


EDITS = {  # what is changed in a sound file
    "newer": (
        lambda f: f.attrs.modify("format_version", FORMAT_VERSION + 1),
        f"format_version is {FORMAT_VERSION + 1}, this program reads {FORMAT_VERSION}",
    ),
    "without surface": (lambda f: f.pop("surface"), "damaged"),
    "without one of its numbers": (lambda f: f["steps/0000"].attrs.pop("a_r"), "damaged"),
    "with a field of another size": (of_another_size, "the surface has (6, 5)"),
    "with a huge field without numbers": (huge, "gap has no numbers at some points"),
    "the same, packed": (
        partial(huge, chunks=(1, HUGE), compression="gzip"),
        "gap has no numbers at some points",
    ),
    "with a link out of it": (moved_out, "gap is a link to another file"),
}
RESULTS = {
    "truncated": (lambda p: cut(p, sound(p), 1 - 1e-6), "truncated file"),
    "half of it": (lambda p: cut(p, sound(p), 0.5), "truncated file"),
    "empty": (lambda p: p.write_bytes(b""), "not an HDF5 file"),
    "a text": (lambda p: p.write_text("hello"), "not an HDF5 file"),
    "HDF5 of another program": (lambda p: p.write_bytes(raw_h5(p)), "not a result of hpc-gfmd"),
    "garbled near its beginning": (lambda p: garbled(p, sound(p)[:4000]), "out.h5: "),
    "one bit of a number": (lambda p: one_bit(p, sound(p), np.float64(0.25).tobytes()), "damaged"),
    "one bit of a text": (lambda p: one_bit(p, sound(p), b'"converged"'), "damaged"),
    **{name: (partial(edit, change=change), words) for name, (change, words) in EDITS.items()},
    "a folder": (lambda p: p.mkdir(), "is a folder"),
    "a pipe": (os.mkfifo, "is no file"),
}
