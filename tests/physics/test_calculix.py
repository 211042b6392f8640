"""The exported interface law between two blocks in CalculiX: pressure, closure and temperature
jump."""

import os
import re
import shutil
import subprocess

import numpy as np
import pytest
from contacts import rough_wall

import hpc_gfmd

SIDE = 0.01  # of the cubes, m
MODULUS = 1e15  # Pa: the blocks are practically rigid
CONDUCTIVITY = 1e9  # W/(m K): the temperature of each block is uniform
PRESSURE = 37e6
CONDUCTIVITIES = 60.0, 240.0  # of the two bodies in the law; their harmonic mean is 96
JUMP = 100.0  # K

ccx = shutil.which("ccx")
pytestmark = pytest.mark.skipif(
    ccx is None and not os.environ.get("CI"), reason="CalculiX (calculix-ccx) is not installed"
)


@pytest.fixture(scope="module")
def law():
    surface = rough_wall((2, 8, 4), seed=2, physical_sizes=("100 um", "100 um"), h_rms="0.5 um")
    names = ["gap_mean", "conductance"]
    return hpc_gfmd.interface_law(surface, "1 MPa", "500 MPa", quantities=names, E_star="110 GPa")


def deck(interaction, load, length=1.0, pressure=1.0):
    """Return the input of two stacked cubes, of which the lower one is fixed at the bottom.

    length, pressure: units, in m and Pa.
    """
    side = SIDE / length
    corners = [(i * side, j * side, k * side) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    nodes = [*corners, *((x, y, z + side) for x, y, z in corners)]
    lines = ["*NODE", *(f"{n},{x!r},{y!r},{z!r}" for n, (x, y, z) in enumerate(nodes, 1))]
    lines += ["*ELEMENT,TYPE=C3D8,ELSET=BLOCKS", "1,1,2,4,3,5,6,8,7", "2,9,10,12,11,13,14,16,15"]
    lines += ["*NSET,NSET=BOTTOM", "1,2,3,4", "*NSET,NSET=TOP", "13,14,15,16"]
    lines += ["*NSET,NSET=ALL,GENERATE", "1,16", "*NSET,NSET=UPPER,GENERATE", "9,16"]
    lines += ["*MATERIAL,NAME=STIFF", "*ELASTIC", f"{MODULUS / pressure!r},0.", "*CONDUCTIVITY"]
    lines += [f"{CONDUCTIVITY * length}", "*EXPANSION", "0."]  # larger ones do not converge in mm
    lines += ["*SOLID SECTION,ELSET=BLOCKS,MATERIAL=STIFF"]
    lines += ["*SURFACE,NAME=BELOW,TYPE=ELEMENT", "1,S2", "*SURFACE,NAME=ABOVE,TYPE=ELEMENT"]
    lines += ["2,S1", *interaction]
    lines += ["*CONTACT PAIR,INTERACTION=ROUGH,TYPE=NODE TO SURFACE", "ABOVE,BELOW"]
    lines += ["*INITIAL CONDITIONS,TYPE=TEMPERATURE", "ALL,0."]
    lines += ["*BOUNDARY", "BOTTOM,1,3", "UPPER,1,2"]
    lines += ["*STEP,NLGEOM,INC=1000", "*COUPLED TEMPERATURE-DISPLACEMENT,STEADY STATE", "0.1,1."]
    lines += ["*BOUNDARY", "BOTTOM,11,11,0.", f"TOP,11,11,{JUMP}", *load]
    lines += ["*NODE PRINT,NSET=UPPER", "U", "*NODE PRINT,NSET=BOTTOM,TOTALS=ONLY", "RFL"]
    lines += ["*CONTACT PRINT,SLAVE=ABOVE,MASTER=BELOW", "CSTR", "*END STEP"]
    return "\n".join(lines) + "\n"


def run(folder, text):
    """Run CalculiX and return the final pressures, closure (m) and heat flow (W)."""
    assert ccx, "CalculiX is not installed: apt-get install calculix-ccx"
    (folder / "blocks.inp").write_text(text)
    process = subprocess.run(
        [ccx, "blocks"], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert process.returncode == 0, process.stdout[-2000:]
    printed = (folder / "blocks.dat").read_text()

    def rows(title):
        block = printed.rpartition(title)[2].split("\n\n")[1]
        return np.array([line.split() for line in block.splitlines()], float)

    pressures = rows("contact stress")[:, 1]
    closure = -rows("displacements")[0, 3]
    heat = float(re.findall(r"total heat generation.*\n\n\s+(\S+)", printed)[-1])
    return pressures, closure, -heat


@pytest.mark.parametrize(
    ("units", "length", "pressure"), [("SI", 1.0, 1.0), ("mm-N-MPa", 1e-3, 1e6)]
)
def test_pressure_and_closure(law, tmp_path, units, length, pressure):
    hpc_gfmd.write_law(law.in_units(units), tmp_path / "law.inp", conductivity=CONDUCTIVITIES)
    load = ["*DLOAD", f"2,P2,{PRESSURE / pressure!r}"]
    text = deck(["*INCLUDE,INPUT=law.inp"], load, length, pressure)
    pressures, closure, _ = run(tmp_path, text)
    np.testing.assert_allclose(pressures, PRESSURE / pressure, rtol=1e-4)
    wanted = law.gap_at_touch - law("gap_mean", PRESSURE)
    assert closure * length == pytest.approx(wanted, rel=2e-3)


def test_temperature_jump(law, tmp_path):
    """The conductance at the pressure of the load.

    The thermal part of CalculiX 2.20 needs an exponential behaviour to find the pressure of a node,
    which therefore replaces the table here.
    """
    hpc_gfmd.write_law(law, tmp_path / "law.inp", conductivity=CONDUCTIVITIES)
    written = (tmp_path / "law.inp").read_text()
    behaviour = "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=EXPONENTIAL\n1E-6,1E6\n*GAP"
    exponential, count = re.subn(r"\*SURFACE BEHAVIOR.*?\*GAP", behaviour, written, flags=re.DOTALL)
    assert count == 1
    (tmp_path / "law.inp").write_text(exponential)
    text = deck(["*INCLUDE,INPUT=law.inp"], ["*DLOAD", f"2,P2,{PRESSURE}"])
    pressures, _, heat = run(tmp_path, text)
    np.testing.assert_allclose(pressures, PRESSURE, rtol=1e-3)
    conductance = heat / (SIDE**2 * JUMP)
    assert conductance == pytest.approx(96.0 * law("conductance", PRESSURE), rel=5e-3)
