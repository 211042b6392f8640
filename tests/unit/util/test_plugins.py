"""Entry points of another package: the examples of docs/developer.md as an installed package."""

import re
from pathlib import Path

from mpi_harness import environment, json_of, python

PAGE = (Path(__file__).parents[3] / "docs" / "developer.md").read_text()
PARTS = {  # heading: module of the package, entry point, the folder it could be dropped in
    "Add a body": ("graded", "hpc_gfmd.bodies", "bodies"),
    "Add a law of attraction": ("algebraic", "hpc_gfmd.laws", "laws"),
    "Add a solver": ("calm", "hpc_gfmd.solvers", "solvers"),
    "Add a kernel": ("peaks", None, "kernels"),
    "Add an observable": ("pressure_max", "hpc_gfmd.observables", "contact"),
}
SCRIPT = """
import json
import sys
import numpy as np
import hpc_gfmd
from hpc_gfmd.bodies import body_classes
options = {"name": "calm", "observables": ["pressure_max"], "residual": 1e-6}
wave = 0.01 * np.cos(np.arange(16) * np.pi / 8)[:, None]
solution = hpc_gfmd.solve(wave, 0.01, boundary="periodic", **options)
assert "doi" in str(solution.references())
assert "matplotlib" not in sys.modules  # which takes a tenth of a second or more
highest = [solution.observable("pressure_max"), solution.pressure.max()]
print(json.dumps([*highest, [*body_classes()]]))
"""
LAW = "from hpc_gfmd.laws import law_named; print(law_named('algebraic', 2.0, 1.0).energy(1.0))"


def test_examples_of_the_developer_page_as_a_package(tmp_path):
    package = tmp_path / "gfmd_extra"
    points = {}
    package.mkdir()
    for heading, (module, group, folder) in PARTS.items():
        code = re.search(rf"## {heading}\n.*?```python\n(.*?)```", PAGE, re.DOTALL)[1]
        code = code.replace("..kernels.peaks", "gfmd_extra.peaks")
        (package / f"{module}.py").write_text(code.replace("from .", f"from hpc_gfmd.{folder}."))
        points[group] = f"[{group}]\n{module} = gfmd_extra.{module}\n"
    metadata = tmp_path / "gfmd_extra-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: gfmd-extra\nVersion: 1.0\n")
    env = environment()
    env |= {"PYTHONPATH": f"{tmp_path}:{env['PYTHONPATH']}"}
    # alone: with a further law all kernels are compiled again
    (metadata / "entry_points.txt").write_text(points.pop("hpc_gfmd.laws"))
    assert json_of(None, ["-c", LAW], env=env) == -2 / 8
    del points[None]  # of the kernel
    (metadata / "entry_points.txt").write_text("".join(points.values()))
    observed, highest, bodies = json_of(None, ["-c", SCRIPT], env=env)
    assert observed == highest > 0
    assert bodies[0] == "graded"
    for code, error in (
        ("import nothing_of_this_name", "calm = gfmd_extra.calm does not load: No module"),
        ("", 'calm has no class with name = "calm"'),
    ):
        (package / "calm.py").write_text(code)
        assert f"hpc_gfmd.solvers: {error}" in python(None, ["-c", SCRIPT], env=env).stderr
