"""Height maps from files, peaks up; the first bytes of a file decide its format."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from ..scene.height_maps import ANY
from ..util.errors import SceneError, is_mistake, one_line
from ..util.file_names import require_name
from . import arrays_in_files, containers, instruments, pictures, text
from .contents import Contents, contents_of, files_in, format_of
from .heights import require_map
from .metadata import Map, missing_numbers

Opener = Callable[[Contents, Any], Map]
NOT_READ = {  # first bytes of a text: what it is
    b"Scan Parameters": "a profile (line scan) of Dektak, allowed: a map",
    b"X;Y;valid": "a profile (line scan, HFM), allowed: a map",
    b"Zygo ASCII Data File": "Zygo's text of phases, allowed: its XYZ text, .datx or .dat",
    b"DSAA": "a text grid of Surfer, allowed: columns x, y and z, or an ESRI grid",
}
OF_TEXT = ("skip_lines", "decimal", "coordinates")  # keys of [surface] that only text has


def open_map(spec: Any) -> Map:
    """Open the map of a scene with a single path: heights (an array, or sliced like one; nan or
    masked where missing) and Metadata. Arrays in binary files are read later, by rows.
    """
    path = Path(spec.path)
    require_name("surface.path", path)
    if not path.is_file():
        raise SceneError(
            f"surface.path: found {path}, which is no file, allowed: the path of a height map"
        )
    if path.stat().st_size == 0:
        raise SceneError(f"surface.path: found an empty file, {path}, allowed: a height map")
    kind = "a height map"
    try:
        contents = contents_of(path, spec.dataset)
        if contents.unpacked is not None and contents.name == spec.dataset:
            spec = spec.model_copy(update={"dataset": ANY})
        kind, opener = opener_of(contents)
        heights, metadata = opener(contents, spec)
        require_map(heights, "surface.path", f" in {path}")
    except SceneError:
        raise
    except MemoryError as error:
        raise SceneError(f"surface.path: not enough memory to read {path} ({error})") from None
    except Exception as error:
        if is_mistake(error):
            raise
        reason = one_line(str(error), 400) or type(error).__name__
        if kind == "text" and contents.claimed not in ("", "text"):
            kind = f"{contents.claimed}; it is a text"
        raise SceneError(f"surface.path: {path} cannot be read as {kind}: {reason}") from None
    _require_keys_apply(spec, kind)
    if kind not in ("text", "tiff", "png"):  # which look for them before they make heights
        metadata = replace(metadata, missing=missing_numbers(spec, path))
    return heights, replace(metadata, reader=metadata.reader or kind, file_bytes=contents.size)


def opener_of(contents: Contents) -> tuple[str, Opener]:
    """Return the name of the format of a file and the function (contents, spec) that reads it."""
    kind = format_of(contents)
    head = contents.head().removeprefix(b"\xef\xbb\xbf")
    for begin, name in NOT_READ.items():
        if head.startswith(begin):
            raise ValueError(f"it is {name}")
    if kind in ("", "text") and instruments.knows(contents):
        return "other", instruments.read
    if kind == "zip" and contents.path.suffix.lower() in ("", ".zip"):
        return "zip", _archive
    if kind in ("", "zip", "picture"):
        is_text = contents.claimed != "text" or contents.is_mostly_text()
        kind = contents.claimed if contents.claimed and is_text else "other"
    if kind == "hdf5" and contents.claimed == "netcdf":
        kind = "netcdf4"
    return OPENERS[kind]


def _hdf5(contents: Contents, spec: Any) -> Map:
    """Open an HDF5 file, a file of Zygo by its own reader."""
    return instruments.of_zygo(contents, spec) or arrays_in_files.read_hdf5(contents, spec)


def _archive(contents: Contents, spec: Any) -> Map:
    """Read a zip that an instrument wrote, or raise SceneError with the names of its files."""
    with ZipFile(contents.source) as archive:
        names = files_in(archive)
    if instruments.detects(contents) or any(name.lower().endswith(".dsc") for name in names):
        return instruments.read(contents, spec)
    problem = "not given" if spec.dataset == ANY else f"found {spec.dataset!r}"
    allowed = one_line(", ".join(map(repr, names)), 400) or "nothing"
    raise SceneError(
        f"surface.dataset: {problem}, {spec.path} holds {len(names)} files, allowed: the name of"
        f" one with a map: {allowed}"
    )


def _require_keys_apply(spec: Any, kind: str) -> None:
    """Raise SceneError if the scene sets a key that has no meaning for a format, `kind`."""
    of_pictures = () if kind in ("tiff", "png") else ("height_range",)
    for key in (*(() if kind == "text" else OF_TEXT), *of_pictures):
        value = getattr(spec, key)
        if value is not None:
            of = "a TIFF or PNG of whole numbers" if key == "height_range" else "a text"
            raise SceneError(
                f"surface.{key}: found {value!r}, but {spec.path} is read as {kind}, allowed: only"
                f" for {of}"
            )


OPENERS: dict[str, tuple[str, Opener]] = {
    "npy": ("npy", arrays_in_files.read_npy),
    "npz": ("npz", arrays_in_files.read_npz),
    "hdf5": ("hdf5", _hdf5),
    "netcdf4": ("netcdf", arrays_in_files.read_hdf5),
    "netcdf": ("netcdf", arrays_in_files.read_netcdf),
    "numbers": ("text", text.read),
    "text": ("text", text.read),
    "tiff": ("tiff", pictures.read_tiff),
    "png": ("png", pictures.read_png),
    "x3p": ("x3p", instruments.read_x3p),
    "container": ("container", containers.read),
    "zygo xyz": ("zygo xyz", text.read_zygo),
    "other": ("other", instruments.read),  # by SurfaceTopography
}
