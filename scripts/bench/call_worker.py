"""Calls of any version of hpc_gfmd, for before.py, which starts this file with its Python.

It answers lines of JSON:

    {"path": heights, "call": {"pressure": p, ...}}
        Prepare: heights of a .npy file for `solve`, or a text file for `run`. The answer has the
        commit of the package.
    {}
        Call, with its processor time in the answer.
"""

import json
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np

import hpc_gfmd

SIZES = 1.0, 1.0
SCENE = """
surface = {{ kind = "file", path = "{path}", physical_sizes = [1.0, 1.0] }}
load = {{ pressure = {pressure} }}
output = {{ path = "{path}.h5", fields = [] }}
"""


def prepared(path, call):
    """Return a function that makes the call."""
    if path.suffix == ".npy":
        z = np.load(path)
        return lambda: hpc_gfmd.solve(z, physical_sizes=SIZES, **call)
    scene = path.with_suffix(".toml")
    scene.write_text(SCENE.format(path=path, **call))
    return lambda: hpc_gfmd.run(scene, quiet=True, force=True)


def commit():
    """Return the commit of the package, with a + if files have changed since."""
    folder = str(Path(hpc_gfmd.__file__).parent)
    git = ["git", "-C", folder, "describe", "--always", "--dirty=+"]
    return subprocess.run(git, capture_output=True, text=True, check=False).stdout.strip()


def main():
    """Answer all lines."""
    warnings.simplefilter("ignore")
    make = None
    for line in sys.stdin:
        question = json.loads(line)
        if question:
            make = prepared(Path(question["path"]), question["call"])
            print(json.dumps({"commit": commit()}), flush=True)
            continue
        begin = time.process_time()
        make()
        print(json.dumps({"cpu_seconds": time.process_time() - begin}), flush=True)


if __name__ == "__main__":
    main()
