"""The formats of instruments and their programs, read by SurfaceTopography."""

import re
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import replace
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np

from ..scene.height_maps import ANY
from ..util.errors import SceneError, one_line
from ..util.lengths import length_factor
from ..util.libraries import surface_topography
from .contents import Contents
from .metadata import Map, Metadata, of_topography

OWN_FORMATS = ("xyz", "asc", "matrix", "npy", "npz", "h5", "nc", "hgt")  # not its readers are used
PREFERRED = re.compile(r"topo|height|z[ _-]?sensor|^z$", re.I)
OTHER_QUANTITIES = re.compile(
    r"error|phase|amplitude|deflection|current|friction|potential|intensity|adhesion|lateral", re.I
)
WITHOUT_CHANNELS = ("mat",)  # arrays of any meaning
NANOMETRES_AS_MILLIMETRES = "nms"  # SurfaceTopography 1.27.1 takes the spacing so
_DATA_IN_GWYDDION = re.compile(r"/(\d+)/data")
LONGEST = 1.0  # m: no instrument measures more


def knows(contents: Contents) -> bool:
    """Whether the first bytes of a file are those of an instrument's format."""
    io = surface_topography().IO
    head = contents.head()[: io.MAGIC_BUFFER_SIZE]
    return any(
        reader.can_read(head) == io.MagicMatch.YES
        for reader in io.readers
        if reader.format() not in OWN_FORMATS
    )


def detects(contents: Contents) -> bool:
    """Whether a reader of SurfaceTopography that is used here takes a file."""
    with suppress(Exception):
        return _detected(contents).format() not in OWN_FORMATS
    return False


def read(contents: Contents, spec: Any) -> Map:
    """Read one channel of an instrument's file, by default heights, masked where missing."""
    reader = _reader_of(contents)
    if reader.format() == "gwy" and not _maps_of(reader):
        return _of_gwyddion(contents, spec)
    return _read_channel(reader, spec)


def read_x3p(contents: Contents, spec: Any) -> Map:
    """Read an X3P file, also with files in a folder or another dash in the revision."""
    return _read_channel(_open(_normalised_x3p(contents), "x3p"), spec)


def of_zygo(contents: Contents, spec: Any) -> Map | None:
    """Read an HDF5 file if it is one of Zygo (DATX); None for any other."""
    import h5py

    with h5py.File(contents.source, "r", locking=False) as file:
        if not {"Data", "MetaData"} <= set(file):
            return None
    return _read_channel(_open(contents.source, "datx"), spec)


def recognised(contents: Contents, spec: Any) -> Map | None:
    """Read a file if SurfaceTopography can and finds sizes or a unit in it, else return None."""
    with suppress(Exception):
        heights, metadata = _read_channel(_detected(contents), spec)
        return (heights, metadata) if metadata.sizes or metadata.unit else None
    return None


def topography_of_channel(contents: Contents, dataset: str) -> Any:
    """Return the SurfaceTopography object of a channel, of size 1 x 1 if unknown; raises whatever
    readers raise. The first reader that takes the file may not be the one `read` prefers.
    """
    channel = _channel_of(_detected(contents), dataset)
    sized = channel.physical_sizes is not None
    return channel.topography(**({} if sized else {"physical_sizes": (1.0, 1.0)}))


def _open(source: Any, kind: str | None = None) -> Any:
    """Open a path or BytesIO by a reader of this kind (None: any), which must not print."""
    io = surface_topography().IO
    source = source if isinstance(source, BytesIO) else str(source)
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        return io.open_topography(source, format=kind)


def _detected(contents: Contents) -> Any:
    """Return the reader of SurfaceTopography that takes a file first, or raise its error."""
    return _open(contents.source)


def _reader_of(contents: Contents) -> Any:
    """Return a reader that recognises the bytes, else one that knows the suffix; one that
    recognises them but finds no map comes last.
    """
    io = surface_topography().IO
    suffix = Path(contents.name or contents.path).suffix.lower().lstrip(".")
    named = [
        reader.format()
        for reader in io.readers
        if suffix in reader.file_extensions() and reader.format() not in OWN_FORMATS
    ]
    try:
        reader = _detected(contents)
    except io.CannotDetectFileFormat:
        reader = None
    if reader is not None and reader.format() in OWN_FORMATS:  # more lenient than those here
        reader = None
    if reader is not None and (_maps_of(reader) or reader.format() in named or not named):
        return reader
    reasons = []
    for kind in named:
        try:
            return _open(contents.source, kind)
        except Exception as error:
            reasons.append(f"{kind}: {one_line(str(error)) or type(error).__name__}")
    if reader is not None:
        return reader
    if reasons:
        raise ValueError("; ".join(reasons))
    formats = ", ".join(io.lookup_reader_by_format)
    raise SceneError(
        f"surface.path: the format of {contents.path} is not known, or it is damaged; known are"
        f" npy, npz, text, hdf5, netcdf, tiff, png and, of instruments, {formats}"
    )


def _maps_of(reader: Any) -> list:
    """Return the channels of a reader that are maps, not profiles."""
    return [channel for channel in reader.channels if channel.dim == 2]


def _channel_of(reader: Any, dataset: str) -> Any:
    """Choose a channel: `dataset`, else one of a length and not named "phase" or "error": the
    reader's default, one named as "topography", or the first. ValueError if formats of any arrays
    have several.
    """
    maps = _maps_of(reader)
    if not maps:
        has_profiles = bool(reader.channels)
        raise ValueError(
            "it has no map of heights, only profiles" if has_profiles else "it has no heights"
        )
    names = one_line(", ".join(repr(str(channel.name)) for channel in maps), 400)
    for channel in maps:
        if channel.name == dataset:
            return channel
    if dataset != ANY:
        raise SceneError(f"surface.dataset: found {dataset!r}, allowed in this file: {names}")
    if reader.format() in WITHOUT_CHANNELS:
        wide = [channel for channel in maps if min(channel.nb_grid_pts) > 1]
        if len(wide) != 1:
            raise ValueError(f"surface.dataset: not given, allowed: one of {names}")
        return wide[0]
    default = reader.default_channel
    candidates = [default, *maps] if default.dim == 2 else maps
    lengths = [channel for channel in candidates if _is_length(channel)] or candidates
    usual = [c for c in lengths if not OTHER_QUANTITIES.search(str(c.name))] or lengths
    preferred = [channel for channel in usual if PREFERRED.search(str(channel.name))]
    is_plain = bool(usual) and usual[0] is default
    return default if is_plain else (preferred or usual)[0]


def _is_length(channel: Any) -> bool:
    """Whether the values of a channel are in a unit of length, or in no named unit."""
    unit = channel.unit[-1] if isinstance(channel.unit, tuple | list) else channel.unit
    return unit is None or length_factor(str(unit)) is not None or unit == "A"


def _read_channel(reader: Any, spec: Any) -> Map:
    """Read heights and metadata of the channel that `_channel_of` chooses for spec.dataset."""
    channel = _channel_of(reader, spec.dataset)
    sized = channel.physical_sizes is not None
    topography = channel.topography(**({} if sized else {"physical_sizes": (1.0, 1.0)}))
    heights, metadata = of_topography(topography)
    names = [str(a_map.name) for a_map in _maps_of(reader)]
    other_names = tuple(name for name in names if name != str(channel.name))
    metadata = replace(
        metadata,
        sizes=metadata.sizes if sized else None,
        channel=str(channel.name) if other_names else "",
        other_channels=other_names,
        direction=f"as in the {reader.format()} file",
        reader=reader.format(),
    )
    return heights, _corrected(metadata)


def _corrected(metadata: Metadata) -> Metadata:
    """Return metadata with sizes in nm if an "nms" file was read in mm: above 1 m."""
    unit = length_factor(metadata.sizes_unit or "") or 0.0
    is_wrong = metadata.sizes is not None and max(metadata.sizes) * unit > LONGEST
    if metadata.reader != NANOMETRES_AS_MILLIMETRES or not is_wrong or metadata.sizes is None:
        return metadata
    sizes = tuple(size * 1e-6 for size in metadata.sizes)
    return replace(metadata, sizes=sizes, remarks=("its spacing is in nm, not in mm",))


def _of_gwyddion(contents: Contents, spec: Any) -> Map:
    """Read a Gwyddion file whose maps have no unit of length; SurfaceTopography would skip them."""
    import gwyfile

    with contents.open() as stream:
        container = gwyfile.load(stream)
    numbers = [match[1] for match in map(_DATA_IN_GWYDDION.fullmatch, container) if match]
    fields = {str(container.get(f"/{k}/data/title", f"channel {k}")): k for k in numbers}
    if not fields:
        raise ValueError("it has no map of heights")
    name = next(iter(fields)) if spec.dataset == ANY and len(fields) == 1 else spec.dataset
    if name not in fields:
        allowed = one_line(", ".join(map(repr, fields)), 400)
        raise SceneError(f"surface.dataset: found {name!r}, allowed in {spec.path}: {allowed}")
    field = container[f"/{fields[name]}/data"]
    heights = np.asarray(field.data, np.float64).T
    mask = container.get(f"/{fields[name]}/mask")
    if mask is not None:
        heights = np.ma.masked_array(heights, np.asarray(mask.data).T > 0.5)
    lateral = _unit_of(field, "si_unit_xy")
    return heights, Metadata(
        sizes=(float(field.xreal), float(field.yreal)) if length_factor(lateral) else None,
        sizes_unit=lateral or None,
        unit=_unit_of(field, "si_unit_z") or None,
        direction="to the right in Gwyddion, y down",
        channel=name,
        other_channels=tuple(title for title in fields if title != name),
        reader="gwy",
    )


def _unit_of(field: Any, key: str) -> str:
    """Return the unit of the sizes ("si_unit_xy") or values ("si_unit_z") of Gwyddion, or ""."""
    return str((field.get(key) or {}).get("unitstr", "")).strip()


def _normalised_x3p(contents: Contents) -> BytesIO:
    """Return a copy of an X3P archive with main.xml and its revision as in the standard."""
    out = BytesIO()
    with contents.open() as stream, ZipFile(stream) as archive, ZipFile(out, "w") as clean:
        names = archive.namelist()
        main = min((name for name in names if Path(name).name == "main.xml"), key=len)
        folder = main.removesuffix("main.xml")
        for name in names:
            if not name.startswith(folder) or name.endswith("/"):
                continue
            data = archive.read(name)
            if name == main:
                data = _plain_revision(data)
            clean.writestr(name.removeprefix(folder), data)
    out.seek(0)
    return out


def _plain_revision(xml: bytes) -> bytes:
    """Return main.xml with the dash of its revision as in the standard, whatever its encoding."""
    text = xml.decode("utf-8", "surrogateescape")
    text = re.sub(r"ISO\s*5436\s*[-\u2010-\u2015\u2212\udc96]\s*2000", "ISO5436 - 2000", text)
    return text.encode("utf-8", "surrogateescape")
