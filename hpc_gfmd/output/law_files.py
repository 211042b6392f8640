"""Files of an interface law: CSV with units, and input of CalculiX and Abaqus."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Sequence
from io import StringIO
from os import PathLike
from pathlib import Path

import numpy as np

from ..util.atomic import atomic_write
from ..util.errors import SceneError
from ..util.quantities import factor
from .interface_law import InterfaceLaw, interpolate
from .unit_systems import system_of

MOST_ROWS = 400  # CalculiX reads no longer table
UNITS = "units: "  # begins the line that names them
STRAIGHT = 1e-3  # relative deviation of straight lines from the law, in tables for finite elements
INTERACTION = re.compile(r"[A-Za-z]\w{0,79}", re.ASCII)  # a name that all programs read
FACT = re.compile(r"^# (\w+) = ([-+.\deE]+)(?: (\S+))?$", re.MULTILINE)


def write_law(
    law: InterfaceLaw,
    path: str | PathLike,
    conductivity: float | Sequence[float] | None = None,
    name: str = "ROUGH",
) -> Path:
    """Write an interface law in the format that belongs to the suffix of the path.

    Parameters
    ----------
    law : InterfaceLaw
        The law, which is not changed.
    path : path
        The file, which is replaced if it exists. ".csv": everything, with units. ".inp": CalculiX
        and Abaqus, `*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR` and `*GAP CONDUCTANCE`.
    conductivity : float or pair of floats, optional
        Thermal conductivities of the two bodies, in W/(m K) if lengths are in m; a single number
        holds for both. Their harmonic mean times the conductance of the law (1/length) is the
        conductance per area and kelvin in ".inp", which contains none without it. A ".csv" only
        records it in its heading.
    name : str
        Name of the surface interaction in ".inp": a letter, then letters, digits and underscores,
        at most 80 in all.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    SceneError
        For another suffix, a folder that does not exist, another name, for conductivities that are
        not positive, and if ".inp" is requested from a law without a mean gap or whose mean gap
        does not decrease, or with a conductivity from one without conductance.

    Notes
    -----
    Units are those of the law; the first lines of the file name them. `law.in_units("mm-N-MPa")`
    changes them. The conductivity is in W/(m K) in all systems of units.

    The overclosure is `gap_at_touch` minus the mean gap: 0 where the pressure is 0. The reference
    planes of the finite elements are the mean planes of the two surfaces, moved apart by
    `gap_at_touch`. Finite element programs interpolate these tables linearly; the tables have so
    many rows that this deviates from the law by less than 0.1 % of the overclosure.
    """
    path = Path(path)
    if conductivity is not None:
        conductivity = harmonic_mean(conductivity)
    require_file(path, law.values, conductivity, name)
    text = WRITERS[path.suffix](law, conductivity, name)
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def require_file(
    path: str | PathLike,
    quantities: Container[str],
    conductivity: float | None = None,
    name: str = "ROUGH",
) -> None:
    """Raise SceneError unless `write_law` can write a law of these quantities."""
    path = Path(path)
    if path.suffix not in WRITERS:
        raise SceneError(f"path: found {str(path)!r}, allowed: one in {', '.join(WRITERS)}")
    if not path.parent.is_dir():
        raise SceneError(f"path: no such folder: {path.parent}")
    if not INTERACTION.fullmatch(name):
        raise SceneError(
            f"name: found {name!r}, allowed: a letter, then letters, digits and underscores, at"
            " most 80 in all"
        )
    if path.suffix == ".csv":
        return
    if "gap_mean" not in quantities:
        raise SceneError(f"{path}: a law for finite elements needs gap_mean among its quantities")
    if conductivity is not None and "conductance" not in quantities:
        raise SceneError(
            f"{path}: conductivity needs conductance among the quantities of the law, which only"
            " half-spaces have"
        )


def harmonic_mean(conductivity: float | Sequence[float]) -> float:
    """Return 2 k1 k2/(k1 + k2) of two conductivities, or the single value of both bodies."""
    values = np.atleast_1d(np.asarray(conductivity, dtype=float))
    if values.size not in (1, 2) or not (np.isfinite(values) & (values > 0)).all():
        raise SceneError(
            f"conductivity: found {conductivity!r}, allowed: one positive number, or two"
        )
    return float(values.size / np.sum(1 / values))


def read_law(path: str | PathLike) -> InterfaceLaw:
    """Read an interface law from a CSV file that `write_law` has written.

    Parameters
    ----------
    path : path
        The ".csv", which holds the whole law.

    Returns
    -------
    InterfaceLaw

    Raises
    ------
    SceneError
        If the file cannot be read or is no interface law.
    """
    path = Path(path)
    if path.suffix != ".csv":
        raise SceneError(
            f"path: found {str(path)!r}, allowed: a .csv, which holds the whole law (other files"
            " hold only what finite elements need)"
        )
    try:
        return _law_of(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror}") from None
    except (ValueError, KeyError, AttributeError):
        raise SceneError(f"{path}: not an interface law written by hpc-gfmd law") from None


def finite_element_table(law: InterfaceLaw) -> tuple[np.ndarray, np.ndarray]:
    """Return (pressure, overclosure) from (0, 0) for linear interpolation to STRAIGHT, or MOST_ROWS
    rows; rows that do not increase the overclosure are left out.
    """

    def overclosure(pressure: np.ndarray) -> np.ndarray:
        return law.gap_at_touch - interpolate(law.pressure, law.values["gap_mean"], pressure)

    pressure = law.pressure[np.isfinite(law.values["gap_mean"])]
    while True:
        middle = np.sqrt(pressure[1:] * pressure[:-1])
        straight = np.interp(middle, pressure, overclosure(pressure))
        curved = overclosure(middle)
        coarse = np.abs(curved - straight) > STRAIGHT * curved
        if not coarse.any() or pressure.size + coarse.sum() >= MOST_ROWS:
            break
        pressure = np.sort(np.concatenate([pressure, middle[coarse]]))
    closure = overclosure(pressure)
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(closure)) > 0])
    rising &= closure > 0
    if not rising.any():
        raise SceneError(
            "law: no pressure decreases the mean gap; a table for finite elements needs a rough"
            " surface"
        )
    return np.concatenate([[0.0], pressure[rising]]), np.concatenate([[0.0], closure[rising]])


def _heading(law: InterfaceLaw, mark: str, conductivity: float | None) -> str:
    """Return comment lines, each after `mark`: the description of the law, then its facts."""
    unit = law.units["gap_at_touch"]
    facts = [f"gap_at_touch = {law.gap_at_touch!r} {unit}".rstrip(), f"surfaces = {law.surfaces}"]
    if conductivity is not None:
        facts.append(f"conductivity = {conductivity!r} W/(m.K)")
    lines = ["law of an interface, by hpc-gfmd", _units_line(law), *law.about, *facts]
    return "".join(f"{mark} {line}\n" for line in lines)


def _units_line(law: InterfaceLaw) -> str:
    """Return a line with the units of a law and of what finite elements make of it."""
    system = system_of(law.units["gap_at_touch"], law.units["pressure"])
    if system is None:
        return f"{UNITS}those of the scene, which has none"
    return (
        f"{UNITS}{system.length}, {system.force}, {system.pressure}, s, K; conductance per area in"
        f" {system.power}/({system.length}^2 K)"
    )


def _csv(law: InterfaceLaw, conductivity: float | None, name: str) -> str:
    """Return the law as CSV with units in the headings of the columns; `name` is not used."""
    table = law.to_dataframe()
    units = table.attrs["units"]
    table.columns = [f"{column} [{units[column]}]" for column in table.columns]
    # seventeen digits: what is read back is equal
    return _heading(law, "#", conductivity) + table.to_csv(index=False, float_format="%.17g")


def _inp(law: InterfaceLaw, conductivity: float | None, name: str) -> str:
    """Return the law as input of CalculiX or Abaqus, with conductance if conductivity is given."""
    pressure, closure = finite_element_table(law)
    lines = [f"*SURFACE INTERACTION, NAME={name}"]
    lines += ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR"]
    lines += [f"{p:.9E}, {o:.9E}" for p, o in zip(pressure, closure, strict=True)]
    if conductivity is not None:
        system = system_of(law.units["gap_at_touch"], law.units["pressure"])
        unit = 1.0  # of conductivities in this system, in W/(m K)
        if system:
            unit = factor(system.pressure, "pressure") * factor(system.length) ** 2
        conductance = interpolate(law.pressure, law.values["conductance"], pressure[1:])
        rows = zip(conductivity / unit * conductance, pressure[1:], strict=True)
        lines += ["*GAP CONDUCTANCE, PRESSURE", f"{0:.9E}, {0:.9E}, 0."]
        lines += [f"{h:.9E}, {p:.9E}, 0." for h, p in rows if np.isfinite(h)]
    return _heading(law, "**", conductivity) + "\n".join(lines) + "\n"


def _law_of(text: str) -> InterfaceLaw:
    """Return the law in a text of `_csv`; KeyError, ValueError or AttributeError for others."""
    from pandas import read_csv

    table = read_csv(StringIO(text), comment="#", float_precision="round_trip")
    units = {}
    columns = {}
    for heading in table.columns:
        name, unit = re.fullmatch(r"(\w+) \[(.*)\]", heading).groups()  # type: ignore[union-attr]
        units[name] = unit
        columns[name] = table[heading].to_numpy(float)
    names = [name for name in columns if f"{name}_error" in columns]
    facts = {name: number for name, number, _ in FACT.findall(text)}
    length_unit = {name: unit for name, _, unit in FACT.findall(text)}["gap_at_touch"]
    _, *about = (line for line in text.splitlines() if line.startswith("#"))
    return InterfaceLaw(
        columns["pressure"],
        {name: columns[name] for name in names},
        {name: columns[f"{name}_error"] for name in names},
        {name: columns[f"{name}_scatter"] for name in names},
        float(facts["gap_at_touch"]),
        {name: units[name] for name in ("pressure", *names)} | {"gap_at_touch": length_unit},
        int(facts["surfaces"]),
        tuple(
            line.removeprefix("# ")
            for line in about
            if not (FACT.match(line) or line.startswith(f"# {UNITS}"))
        ),
    )


WRITERS: dict[str, Callable[[InterfaceLaw, float | None, str], str]] = {".csv": _csv, ".inp": _inp}
