"""Files of an interface law: CSV with units, input for CalculiX and Abaqus, and for MOOSE."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Sequence
from io import StringIO
from os import PathLike
from pathlib import Path

import numpy as np

from ..util.atomic import atomic_write
from ..util.errors import SceneError
from .interface_law import InterfaceLaw, interpolate

MOST_ROWS = 400  # CalculiX reads no longer table
STRAIGHT = 1e-3  # relative deviation of straight lines from the law, in tables for finite elements
INTERACTION = re.compile(r"[A-Za-z]\w*", re.ASCII)  # a name that all programs read
FACT = re.compile(r"^[#* ]*(\w+) = ([-+.\deE]+)(?: (\S+))?$", re.MULTILINE)


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
        and Abaqus, `*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR` and `*GAP CONDUCTANCE`. ".i":
        functions of MOOSE.
    conductivity : float or pair of floats, optional
        Thermal conductivities of the two bodies, in W/(m K) if lengths are in m; a single number
        holds for both. Their harmonic mean times the conductance of the law (1/length) is the
        conductance per area and kelvin in files for finite elements, which contain none without
        it. A ".csv" only records it in its heading.
    name : str
        Name of the surface interaction (.inp), or beginning of the names of functions (.i): a
        letter, then letters, digits and underscores.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    SceneError
        For another suffix, a folder that does not exist, another name, for conductivities that are
        not positive, and if files for finite elements are requested from a law without a mean gap
        or whose mean gap does not decrease, or with a conductivity from one without conductance.

    Notes
    -----
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
    """Check that `write_law` can write a law with these quantities to a path; nothing is written.

    Parameters
    ----------
    path : path
        The file.
    quantities : container of str
        Names of the quantities of the law.
    conductivity, name
        As for `write_law`; the conductivity is the mean of both bodies.

    Raises
    ------
    SceneError
        For a suffix without a format, a folder that does not exist, a name that other programs do
        not read, and if a file for finite elements needs a quantity that the law does not have.
    """
    path = Path(path)
    if path.suffix not in WRITERS:
        raise SceneError(f"path: found {str(path)!r}, allowed: one in {', '.join(WRITERS)}")
    if not path.parent.is_dir():
        raise SceneError(f"path: found {str(path)!r}, allowed: a file in a folder that exists")
    if not INTERACTION.fullmatch(name):
        raise SceneError(
            f"name: found {name!r}, allowed: a letter, then letters, digits and underscores"
        )
    if path.suffix == ".csv":
        return
    if "gap_mean" not in quantities:
        raise SceneError("law: found no gap_mean, allowed for finite elements: a law that has it")
    if conductivity is not None and "conductance" not in quantities:
        raise SceneError(
            "conductivity: found with a law that has no conductance, allowed: with a half-space"
        )


def harmonic_mean(conductivity: float | Sequence[float]) -> float:
    """Return 2 k1 k2/(k1 + k2) of two conductivities, or the single value of both bodies.

    Raises
    ------
    SceneError
        Unless there are one or two positive numbers.
    """
    values = np.atleast_1d(np.asarray(conductivity, dtype=float))
    if values.size not in (1, 2) or not (np.isfinite(values) & (values > 0)).all():
        raise SceneError(
            f"conductivity: found {conductivity!r}, allowed: one positive number, or two"
        )
    return float(values.size / np.sum(1 / values))


def read_law(path: str | PathLike) -> InterfaceLaw:
    """Read an interface law from a file that `write_law` has written.

    Parameters
    ----------
    path : path
        ".csv", ".inp" or ".i". Files for finite elements contain only the mean gap and the
        conductance; errors and scatter are nan then.

    Returns
    -------
    InterfaceLaw

    Raises
    ------
    SceneError
        If the file cannot be read or is no interface law.
    """
    path = Path(path)
    if path.suffix not in READERS:
        raise SceneError(f"path: found {str(path)!r}, allowed: one in {', '.join(READERS)}")
    try:
        text = path.read_text(encoding="utf-8")
        return READERS[path.suffix](text)
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror}") from None
    except (ValueError, KeyError, IndexError, AttributeError):
        raise SceneError(
            f"{path}: found no law of an interface, allowed: a file of hpc-gfmd law"
        ) from None


def finite_element_table(law: InterfaceLaw) -> tuple[np.ndarray, np.ndarray]:
    """Return arrays (pressure, overclosure), from (0, 0), for linear interpolation of the law.

    Each interval between the pressures of the law is halved (in the logarithm) until the straight
    line deviates from the law in its middle by less than STRAIGHT times the overclosure, or until
    the next step would make MOST_ROWS rows or more. Rows whose overclosure does not exceed that of
    all rows before are left out. Raises SceneError if only the first row is left, as of a flat
    surface, whose gap is 0 under any pressure.
    """

    def overclosure(pressure: np.ndarray) -> np.ndarray:
        """Return `gap_at_touch` minus the mean gap at some pressures."""
        return law.gap_at_touch - interpolate(law.pressure, law.values["gap_mean"], pressure)

    pressure = law.pressure[np.isfinite(law.values["gap_mean"])]
    while True:
        middle = np.sqrt(pressure[1:] * pressure[:-1])
        share = (middle - pressure[:-1]) / np.diff(pressure)
        ends = overclosure(pressure)
        straight = ends[:-1] + share * np.diff(ends)
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
            "law: found a mean gap that no pressure decreases, allowed for finite elements: that of"
            " a rough surface"
        )
    return np.concatenate([[0.0], pressure[rising]]), np.concatenate([[0.0], closure[rising]])


def _heading(law: InterfaceLaw, mark: str, conductivity: float | None = None) -> str:
    """Return the comment lines at the head of a file; each begins with `mark`.

    They hold the description of the law and facts such as "gap_at_touch = 1e-6 m". `conductivity`
    is the harmonic mean of both bodies, None if it was not given.
    """
    unit = law.units.get("gap_mean", "")
    facts = [f"gap_at_touch = {law.gap_at_touch!r} {unit}".rstrip(), f"surfaces = {law.surfaces}"]
    if conductivity is not None:
        facts.append(f"conductivity = {conductivity!r} W/(m.K)")
    lines = ["law of an interface, by hpc-gfmd", *law.about, *facts]
    return "".join(f"{mark} {line}\n" for line in lines)


def _csv(law: InterfaceLaw, conductivity: float | None, name: str) -> str:
    """Return the law as CSV text with units in the headings of the columns.

    `conductivity` only appears in the comment lines, and `name` is not used.
    """
    table = law.to_dataframe()
    units = table.attrs["units"]
    table.columns = [f"{column} [{units[column]}]" for column in table.columns]
    # seventeen digits: what is read back is equal
    return _heading(law, "#", conductivity) + table.to_csv(index=False, float_format="%.17g")


def _inp(law: InterfaceLaw, conductivity: float | None, name: str) -> str:
    """Return the law as input of CalculiX or Abaqus. `name` is that of the surface interaction.

    It holds the conductance only if `conductivity`, the mean of both bodies, is given. Raises
    SceneError as `finite_element_table`.
    """
    pressure, closure = finite_element_table(law)
    lines = [f"*SURFACE INTERACTION, NAME={name}"]
    lines += ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR"]
    lines += [f"{p:.9E}, {o:.9E}" for p, o in zip(pressure, closure, strict=True)]
    if conductivity is not None:
        lines += ["*GAP CONDUCTANCE, PRESSURE"]
        rows = zip(*_conductance_rows(law, conductivity), strict=True)
        lines += [f"{h:.9E}, {p:.9E}, 0." for p, h in rows]
    return _heading(law, "**", conductivity) + "\n".join(lines) + "\n"


def _moose(law: InterfaceLaw, conductivity: float | None, name: str) -> str:
    """Return the law as functions of MOOSE, whose names begin with `name`.

    The functions are the pressure over the overclosure and, if `conductivity` is given, the
    conductance over the pressure. Raises SceneError as `_inp`.
    """
    pressure, closure = finite_element_table(law)
    tables = {f"{name}_pressure_of_closure": (closure, pressure)}
    if conductivity is not None:
        tables[f"{name}_conductance_of_pressure"] = _conductance_rows(law, conductivity)
    lines = ["[Functions]"]
    for function, (x, y) in tables.items():
        lines += [f"  [{function}]", "    type = PiecewiseLinear"]
        lines += [f"    x = '{_numbers(x)}'", f"    y = '{_numbers(y)}'", "    extrap = false"]
        lines += ["  []"]
    return _heading(law, "#", conductivity) + "\n".join([*lines, "[]"]) + "\n"


def _numbers(values: np.ndarray) -> str:
    """Return numbers as text in one line with ten digits, separated by blanks, for MOOSE."""
    return " ".join(f"{value:.9E}" for value in values)


def _conductance_rows(law: InterfaceLaw, conductivity: float) -> tuple[np.ndarray, np.ndarray]:
    """Return arrays (pressure, conductance per area and kelvin) of a law, from (0, 0).

    The conductance is `conductivity`, the mean of both bodies, times that of the law. The pressures
    are those of `finite_element_table` at which the law has one.
    """
    pressure, _ = finite_element_table(law)
    conductance = interpolate(law.pressure, law.values["conductance"], pressure[1:])
    exists = np.isfinite(conductance)
    return (
        np.concatenate([[0.0], pressure[1:][exists]]),
        np.concatenate([[0.0], conductivity * conductance[exists]]),
    )


def _read_csv(text: str) -> InterfaceLaw:
    """Return the law in a text that `_csv` has written.

    Raises KeyError, ValueError or AttributeError for other texts, as the other readers here do.
    """
    from pandas import read_csv

    table = read_csv(StringIO(text), comment="#")
    units = {}
    columns = {}
    for heading in table.columns:
        name, unit = re.fullmatch(r"(\w+) \[(.*)\]", heading).groups()  # type: ignore[union-attr]
        units[name] = unit
        columns[name] = table[heading].to_numpy(float)
    pressure = columns.pop("pressure")
    names = [name for name in columns if not name.endswith(("_error", "_scatter"))]
    facts = _facts(text)
    return InterfaceLaw(
        pressure,
        {name: columns[name] for name in names},
        {name: columns[f"{name}_error"] for name in names},
        {name: columns[f"{name}_scatter"] for name in names},
        facts["gap_at_touch"],
        {name: units[name] for name in ("pressure", *names)},
        int(facts["surfaces"]),
        _about(text),
    )


def _read_inp(text: str) -> InterfaceLaw:
    """Return the law in a text that `_inp` has written: mean gap, and conductance if present."""
    tables: dict[str, list[list[float]]] = {}
    rows: list[list[float]] = []
    for line in text.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            rows = tables.setdefault(line.partition(",")[0], [])
        else:
            rows.append([float(number) for number in line.split(",")])
    conductance = [row[1::-1] for row in tables.get("*GAP CONDUCTANCE", ())]
    return _of_finite_elements(text, tables["*SURFACE BEHAVIOR"], conductance)


def _read_moose(text: str) -> InterfaceLaw:
    """Return the law in a text that `_moose` has written: mean gap, and conductance if present."""
    functions = re.findall(r"\[(\w+)\]\s+type.*?x = '(.*?)'\s+y = '(.*?)'", text, re.DOTALL)
    tables = {
        function.rsplit("_", 2)[0].rsplit("_", 1)[1]: np.array([x.split(), y.split()], float).T
        for function, x, y in functions
    }
    pressure = tables["pressure"][:, ::-1].tolist()
    return _of_finite_elements(text, pressure, tables.get("conductance", np.empty((0, 2))).tolist())


def _of_finite_elements(
    text: str, behaviour: Sequence[Sequence[float]], conductance: Sequence[Sequence[float]]
) -> InterfaceLaw:
    """Return a law from rows (pressure, overclosure) and (pressure, conductance) of a file.

    `behaviour` and `conductance` are these rows; the first row of each is (0, 0) and is left out.
    Without rows of conductance the law has none; otherwise it is interpolated linearly at the
    pressures of `behaviour`. `text` is the whole file; its heading has gap_at_touch, the
    conductivity and the unit of length. Errors and scatter are nan.
    """
    facts = _facts(text)
    pressure, closure = np.array(behaviour[1:], float).T
    values = {"gap_mean": facts["gap_at_touch"] - closure}
    if conductance:
        p, h = np.array(conductance[1:], float).T
        values["conductance"] = np.interp(
            pressure, p, h / facts["conductivity"], left=np.nan, right=np.nan
        )
    unknown = {name: np.full_like(pressure, np.nan) for name in values}
    unit = re.search(r"gap_at_touch = \S+ (\S+)", text)
    length = unit[1] if unit else ""
    units = {"pressure": "Pa" if length == "m" else "", "gap_mean": length}
    units["conductance"] = f"1/{length}" if length else ""
    return InterfaceLaw(
        pressure,
        values,
        unknown,
        unknown,
        facts["gap_at_touch"],
        {name: units[name] for name in ("pressure", *values)},
        int(facts["surfaces"]),
        _about(text),
    )


def _facts(text: str) -> dict[str, float]:
    """Return {name: number} of the facts in the heading of a file, such as "conductivity"."""
    return {name: float(number) for name, number, _ in FACT.findall(text)}


def _about(text: str) -> tuple[str, ...]:
    """Return the description in the heading of a file: all but its first line and the facts."""
    heading = [line for line in text.splitlines() if line.startswith(("#", "**"))]
    lines = [re.sub(r"^[#*]+ ?", "", line) for line in heading]
    return tuple(line for line in lines[1:] if not FACT.match(line))


WRITERS: dict[str, Callable[[InterfaceLaw, float | None, str], str]] = {
    ".csv": _csv,
    ".inp": _inp,
    ".i": _moose,
}
READERS: dict[str, Callable[[str], InterfaceLaw]] = {
    ".csv": _read_csv,
    ".inp": _read_inp,
    ".i": _read_moose,
}
