"""Every reader of files as a target of fuzzing: a file is read, or refused in one line."""

import faulthandler
import os
import resource
import signal
from pathlib import Path

from hpc_gfmd.commands.common import as_json
from hpc_gfmd.commands.show import as_dict, as_text
from hpc_gfmd.output.read import CHECKPOINT, read_result, read_state
from hpc_gfmd.scene import File, Scene, load_scene
from hpc_gfmd.surface.topography import open_topography
from hpc_gfmd.theory import tfc
from hpc_gfmd.util.errors import GfmdError

LARGEST_FIELD = 2**20  # points of a field that is read
SECONDS = 1  # CPU time of the child that reads a file
BYTES = 8 * 2**30  # its address space
LONGEST_MESSAGE = 1500  # characters
# Files that may crash the HDF5 library, which is not our concern.
HDF5 = "hdf5", "netcdf", "result", "checkpoint"


def read_scene(path):
    """Read a scene file; the scene survives a round trip."""
    scene = load_scene(path)
    assert Scene.from_toml(scene.to_toml()) == scene
    assert len(scene.identity()) == 64
    scene.warnings()


def read_heights(path):
    """Read all rows of a height map."""
    spec = File(kind="file", path=str(path), physical_sizes=(1, 1), boundary="periodic")
    n = open_topography(spec).n
    rows = max(1, min(64, LARGEST_FIELD // n[1]))
    for start in range(0, n[0] if n[0] * n[1] <= LARGEST_FIELD else 0, rows):
        z = open_topography(spec).rows(start, min(start + rows, n[0]))
        assert z.dtype == "f8"
        assert z.shape == (min(rows, n[0] - start), n[1])


def read_results(path):
    """Read a result file as `show` does, as text and JSON, with its fields and its scene."""
    result = read_result(path)
    assert as_text(result)
    as_json(as_dict(result))
    for fields in result.fields:
        for stored in fields.values():
            if stored.shape[0] * stored.shape[1] <= LARGEST_FIELD:
                assert stored.read(0, stored.shape[0]).shape == stored.shape
    Scene.from_toml(result.scene_toml)


def read_checkpoint(path):
    """Read a checkpoint and its arrays."""
    checkpoint = read_state(path, CHECKPOINT, "abc")
    for field in checkpoint.fields[0].values():
        if field.shape[0] * field.shape[1] <= LARGEST_FIELD:
            field.read()


def read_coefficients(path):
    """Read a table of coefficients and apply it."""
    tfc.extrapolate(2.0, "kappa", 0.5, 0.007, 0.5, 0.001, 0.5, table=tfc.read_table(path))


READERS = {  # target: (reader, extension of its files)
    "scene": (read_scene, ".toml"),
    "npy": (read_heights, ".npy"),
    "hdf5": (read_heights, ".h5"),
    "netcdf": (read_heights, ".nc"),
    "result": (read_results, ".h5"),
    "checkpoint": (read_checkpoint, ".h5"),
    "coefficients": (read_coefficients, ".json"),
}


def outcome(target, path):
    """Return "read" or "refused".

    Anything else raises; a crash of the HDF5 library ends the process.
    """
    try:
        READERS[target][0](Path(path))
    except GfmdError as error:
        message = str(error)
    else:
        return "read"
    assert message.isprintable(), ascii(message)
    assert 0 < len(message) < LONGEST_MESSAGE, message
    return "refused"


def outcome_apart(target, path):
    """Return `outcome` in a fork, or "crashed" if the HDF5 library ended it."""
    outcome_in_child = _in_a_fork(lambda: outcome(target, path))
    assert outcome_in_child is not None or target in HDF5, f"{path} ends the process that reads it"
    return outcome_in_child or "crashed"


def _in_a_fork(function):
    """Call a function in a fork and return its text ("" for None), or None if the process died.

    Raises AssertionError if the function raises.
    """
    read_end, write_end = os.pipe()
    child = os.fork()
    if child == 0:
        faulthandler.disable()
        for fatal in (  # a fuzzer's handler would wait for ever
            signal.SIGABRT,
            signal.SIGSEGV,
            signal.SIGBUS,
            signal.SIGFPE,
            signal.SIGILL,
            signal.SIGALRM,
        ):
            signal.signal(fatal, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
        resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        try:
            answer = f"+{function() or ''}"
        except BaseException as error:
            answer = f"-{type(error).__name__}: {error}"
        try:
            os.write(write_end, answer.encode(errors="replace")[:4000])
        finally:
            os._exit(0)
    os.close(write_end)
    with open(read_end, "rb") as pipe:
        answer = pipe.read().decode(errors="replace")
    died = os.waitpid(child, 0)[1] != 0 or not answer or answer.startswith("-MemoryError")
    assert died or answer.startswith("+"), answer
    return None if died else answer[1:]
