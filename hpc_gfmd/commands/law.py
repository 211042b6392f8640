"""`hpc-gfmd law`: the law of an interface, for other programs."""

from __future__ import annotations

import re
from argparse import ArgumentParser, Namespace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from ..output.unit_systems import SYSTEMS
from ..util.errors import SceneError
from ..util.quantities import prefixed
from .common import add_file, add_json, add_overrides, add_quiet, as_json

if TYPE_CHECKING:
    from ..output.interface_law import InterfaceLaw

PLAIN_NUMBER = re.compile(r"[-+.\deE]+")
HELP = "area, gap, stiffness, conductance against pressure, for finite elements"
DESCRIPTION = """
Compute the interface law of a scene: contact area, mean gap, stiffness and conductance (or other
numbers) against the mean pressure, with errors, from as few loads as an interpolation with the
requested error needs. The loads and the output of the scene are ignored. Several scenes, or several
seeds of one, give the mean and its scatter. Files: .csv (all), .inp (CalculiX and Abaqus:
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR and *GAP CONDUCTANCE)."""


def share(text: str) -> float:
    """Convert a share such as 1% or 0.01 to a number. Raises ValueError for other texts."""
    percent = text.strip().removesuffix("%")
    return float(percent) / 100 if percent != text.strip() else float(percent)


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the command to its parser."""
    add_file(parser, "scene", metavar="SCENE.toml", nargs="+", help="scene files")
    parser.add_argument(
        "--from", dest="start", metavar="P", required=True, help='lowest mean pressure, as "1 MPa"'
    )
    parser.add_argument(
        "--to", dest="stop", metavar="P", required=True, help='highest mean pressure, as "1 GPa"'
    )
    parser.add_argument(
        "--error",
        type=share,
        default=0.05,
        metavar="SHARE",
        help="deviation from the law, of the load amid an interval, up to which no more are solved"
        " (default: 5%%); loads between deviate by up to the printed errors",
    )
    parser.add_argument(
        "--realisations",
        type=int,
        default=1,
        metavar="N",
        help="number of seeds of a self-affine surface",
    )
    parser.add_argument(
        "--quantities",
        metavar="NAME",
        nargs="+",
        help="numbers of a load; default: a_r, gap_mean, stiffness, conductance; critical_gap_x or"
        " critical_gap_y finds the load at which a seal is tight",
    )
    parser.add_argument(
        "--conductivity",
        type=float,
        nargs="+",
        metavar="K",
        help="thermal conductivity of the bodies, one or two numbers, in W/(m K) where the scene"
        " has units: puts the conductance into files for finite elements",
    )
    parser.add_argument(
        "--units",
        choices=list(SYSTEMS),
        help="of what is printed and written (default: SI where the scene has units)",
    )
    parser.add_argument(
        "--name", default="ROUGH", help="name of the surface interaction (default: ROUGH)"
    )
    add_file(
        parser,
        "-o",
        "--output",
        action="append",
        default=[],
        metavar="FILE",
        help="file that ends in .csv or .inp; may be repeated",
    )
    add_overrides(parser, "change a setting of the scenes: table.key=value")
    parser.add_argument("--force", action="store_true", help="replace files that exist")
    add_json(parser, "a table")
    add_quiet(parser)


def main(args: Namespace) -> int:
    """Compute a law and write its files; returns 3 if a load did not converge. Collective."""
    from ..output.interface_law import QUANTITIES
    from ..output.law_files import harmonic_mean, require_file, write_law
    from ..parallel.guard import on_rank_0
    from ..parallel.world import world
    from ..runs.interface_law import interface_law
    from ..scene import load_scene

    comm = world()
    conductivity = None if args.conductivity is None else harmonic_mean(args.conductivity)

    quantities = args.quantities or QUANTITIES

    def scenes() -> list:
        if args.units and PLAIN_NUMBER.fullmatch(args.start):
            raise SceneError(
                f"--units: found {args.units} with --from {args.start}, allowed: pressures with"
                ' units, as "1 MPa"'
            )
        for path in args.output:
            require_file(path, quantities, conductivity, args.name)
            if Path(path).exists() and not args.force:
                raise SceneError(f"{path}: exists, allowed: another name, or --force")
        return [load_scene(path, args.set, needs_load=False) for path in args.scene]

    law = interface_law(
        on_rank_0(comm, "reading the scenes", scenes),
        args.start,
        args.stop,
        args.error,
        quantities=quantities,
        realisations=args.realisations,
        progress=not (args.quiet or args.json),
        comm=comm,
    )
    if args.units:
        law = law.in_units(args.units)

    written: list[str] = []

    def write() -> None:
        for path in args.output:
            write_law(law, path, conductivity, args.name)
            written.append(path)

    # Files first: whoever reads the text may stop reading. A law that cannot be written is printed.
    try:
        on_rank_0(comm, "writing the law", write)
    finally:
        if comm.rank == 0 and not args.quiet:
            print(as_json(as_dict(law)) if args.json else as_text(law), flush=True)
    if comm.rank == 0 and not (args.quiet or args.json):
        for path in written:
            print(f"law: {path}")
    return 0 if law.converged else 3


def as_dict(law: InterfaceLaw) -> dict:
    """Return a law for JSON: its remarks, units and columns, by the names of its CSV file."""
    table = law.to_dataframe()
    columns = {name: table[name].tolist() for name in table}
    return {
        "about": list(law.about),
        "gap_at_touch": law.gap_at_touch,
        "surfaces": law.surfaces,
        "units": table.attrs["units"],
        "law": columns,
    }


def as_text(law: InterfaceLaw) -> str:
    """Return a law as text: its remarks, a table of values with errors, when channels close."""
    from ..output.summary import with_error
    from ..runs.table import aligned

    headings = ["pressure", *law.values]
    units = [law.units[name] for name in headings]
    rows = [headings, ["" if unit in ("", "1") else f"[{unit}]" for unit in units]]
    for k, pressure in enumerate(law.pressure):
        numbers = (
            "0 +- ?"  # of a channel that is closed on this grid
            if values[k] == 0 and law.errors[name][k] == inf
            else with_error(float(values[k]), float(law.errors[name][k]))
            for name, values in law.values.items()
        )
        rows.append([f"{pressure:.4g}", *numbers])
    return "\n".join([*law.about, *aligned(rows), *_tightness(law)])


def _tightness(law: InterfaceLaw) -> list[str]:
    """Return a line for each axis along which a seal becomes tight within the law."""
    unit = law.units["pressure"]
    scale, unit = prefixed(law.pressure.tolist(), unit) if unit == "Pa" else (1.0, unit)
    lines = []
    for axis in "xy":
        name = f"critical_gap_{axis}"
        gaps = law.values.get(name)
        if gaps is not None and (gaps == 0).any() and gaps[0] > 0:
            tight = law.sealing_pressure(axis)
            leaks = int((law.pressure < tight).sum()) - 1
            bar = gaps[leaks] * law.errors[name][leaks]
            lines.append(
                f"tight along {axis} from {tight / scale:.4g} {unit}".rstrip()
                + f", not yet at {law.pressure[leaks] / scale:.4g} {unit}".rstrip()
                + f", on this grid: critical gaps are within {bar:.2g} {law.units[name]}".rstrip()
            )
    return lines
