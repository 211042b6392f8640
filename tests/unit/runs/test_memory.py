"""The memory available to a run (machine, control groups, process), and what a plan shows."""

import resource
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from refusal import refused
from scene_tables import rows, scene_of

from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.runs import memory
from hpc_gfmd.runs.plan import plan_of
from hpc_gfmd.surface import surface_size
from hpc_gfmd.surface.prepare import prepare
from hpc_gfmd.surface.topography import open_topography
from hpc_gfmd.util import machine

GIB = machine.GIB
SCENE = scene_of("""
surface = {kind = "wave", amplitude = 0.1, n = [8192, 8192]}
load = {pressure = 0.1}
solver.precision = "double"
""")


def write_group(folder, limit, used, cached=0, version=2):
    """Write the files of a control group, in bytes; cached: of `used`, file contents."""
    folder.mkdir(parents=True, exist_ok=True)
    names = ("max", "current") if version == 2 else ("limit_in_bytes", "usage_in_bytes")
    for name, value in zip(names, (limit, used), strict=True):
        (folder / f"memory.{name}").write_text(f"{value}\n")
    (folder / "memory.stat").write_text(f"anon 5\ninactive_file {cached}\n")


def test_a_load_whose_precision_is_not_known_may_need_single_only(tmp_path):
    """As of every measured map; what single precision needs is enough for the run to begin."""
    np.save(tmp_path / "z.npy", np.ones((512, 512)))
    text = f"""
surface = {{kind = "file", path = "{tmp_path}/z.npy", physical_sizes = [1, 1], boundary = "free"}}
load = {{p_star = 0.3}}
"""
    scene = scene_of(text)
    size = surface_size(scene.surface)
    single, double = (memory.memory_of(scene, size, itemsize, 1, 1) for itemsize in (4, 8))
    assert single < double
    scene = scene_of(f"{text}machine.memory_gib = {(single + double) / 2}\n")
    memory.require_memory(SerialComm(), scene, size, 1)


def assert_too_little(words):
    with refused(words):
        memory.require_memory(SerialComm(), SCENE, surface_size(SCENE.surface), 1)


@pytest.mark.parametrize(
    ("version", "top", "line"),
    [(2, "", "0::/system/job_7/step_0"), (1, "memory", "4:memory:/system/job_7/step_0")],
)
def test_tightest_control_group_is_the_limit(tmp_path, monkeypatch, version, top, line):
    """Limits of batch jobs are often in an outer group; cached files do not count as used."""
    root = tmp_path / "root"
    outer = root / top / "system/job_7"
    inner = root / top / "system/job_7/step_0"
    write_group(inner, "max" if version == 2 else 2**63 - 4096, GIB, version=version)
    write_group(outer, GIB // 2, GIB // 4, GIB // 8, version=version)
    (tmp_path / "cgroup").write_text(f"3:cpu:/elsewhere\n{line}\n")
    folders = machine.control_groups(root, tmp_path / "cgroup")
    assert inner in folders
    assert not any("elsewhere" in str(folder) for folder in folders)
    monkeypatch.setattr(machine, "control_groups", lambda: folders)
    assert machine.available_gib() == pytest.approx(0.375)
    assert_too_little(r"has 0\.38 GiB")


def test_no_control_groups(tmp_path):
    assert machine.control_groups(tmp_path, tmp_path / "missing") == [tmp_path]
    assert 0 < machine.available_gib() < 1e6


def test_limit_of_the_process(monkeypatch):
    """A limit 1 GiB above what this process takes leaves about 1 GiB, however large it is."""
    assert machine.limit_gib() > 1
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    monkeypatch.setattr(resource, "getrlimit", lambda _: (taken + GIB, taken + GIB))
    assert machine.limit_gib() == pytest.approx(1, abs=0.2)
    assert_too_little("ulimit -v")


@pytest.mark.parametrize(
    ("keys", "copies"),
    [
        pytest.param("crop = [0, 0, 0.5, 0.5]", 0.35, marks=pytest.mark.quick),
        ('crop = [0, 0, 0.5, 0.5], detrend = "tilt"', 0.6),
        ('detrend = "tilt"', 2.3),
        ('boundary = "mirror", detrend = "tilt"', 5.2),
        ("downsample = 8", 1.3),
        pytest.param('boundary = "mirror", refine = 2', 31.0, marks=pytest.mark.quick),
        ("flip = true", 2.1),
        pytest.param('fill = "harmonic", boundary = "periodic"', 3.0, marks=pytest.mark.quick),
        ('window = "hann"', 3.2),
        ('spikes = "median"', 3.2),
    ],
)
def test_preparing_takes_the_memory_that_is_forecast(keys, copies):
    """Of a part of a map one process reads no more, and it holds few copies of that; of what is
    filled nine tenths are missing."""
    z = np.random.default_rng(1).standard_normal((1024, 1024))
    if "fill" in keys:
        z[:920] = np.nan
    np.save("z.npy", z)
    peak, forecast = peak_and_forecast(f'path = "z.npy", physical_sizes = [1, 1], {keys}')
    assert peak < forecast < 1.25 * peak
    assert peak < copies * z.nbytes


@pytest.mark.parametrize("boundary", ["periodic", "mirror"])
@pytest.mark.parametrize("share", [1e-3, 0.5, 0.9])
def test_filling_takes_the_memory_that_is_forecast(boundary, share):
    """However many points are missing here and there."""
    rng = np.random.default_rng(1)
    z = rng.standard_normal((1024, 1024))
    z[rng.random(z.shape) < share] = np.nan
    np.save("z.npy", z)
    keys = f'fill = "harmonic", boundary = "{boundary}"'
    peak, forecast = peak_and_forecast(f'path = "z.npy", physical_sizes = [1, 1], {keys}')
    assert peak < forecast < 1.25 * peak


def _points(z):
    x, y = np.indices(z.shape)
    return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)


@pytest.mark.parametrize(
    ("name", "options", "content"),
    [
        ("z.txt", {"header": "heights in um"}, np.asarray),
        ("z.csv", {"delimiter": ";", "fmt": "%.4g"}, np.asarray),
        ("z.xyz", {"header": "x y z", "fmt": "%.5g"}, _points),
    ],
)
def test_reading_a_text_takes_the_memory_that_is_forecast(name, options, content):
    """Its bytes are held once, besides the numbers."""
    z = np.random.default_rng(1).standard_normal((512, 512))
    np.savetxt(name, content(z), **options)
    if name == "z.csv":
        text = Path(name).read_text()
        Path(name).write_text(text.replace(".", ","))
    peak, forecast = peak_and_forecast(f'path = "{name}", physical_sizes = [1, 1]')
    assert peak < forecast < 1.25 * peak


@pytest.mark.parametrize("shift", [0.0, 0.5])
def test_adding_two_scans_stays_within_the_forecast(shift):
    """Also where they overlap in a part only."""
    z = np.random.default_rng(1).standard_normal((512, 512))
    np.savetxt("fine.txt", z)
    np.savetxt("coarse.txt", z[::2, ::2])
    bodies = f'[{{path = "fine.txt"}}, {{path = "coarse.txt", shift = [{shift}, 0.0]}}]'
    keys = f'bodies = {bodies}, physical_sizes = [1, 1], boundary = "mirror"'
    peak, forecast = peak_and_forecast(keys)
    assert peak < forecast < 1.5 * peak


def peak_and_forecast(keys):
    """Bytes that a map with keys of [surface] takes while it is read and prepared, and what is
    forecast."""
    scene = scene_of(f'surface = {{kind = "file", {keys}}} ; load = {{pressure = 0.1}}')
    spec = scene.surface
    for _ in range(2):  # the first pass includes imports
        tracemalloc.start()
        prepare(open_topography(spec), spec).heights()
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    size = surface_size(spec)
    several = memory.memory_of(scene, size, 4, 64)  # ranks, so that the solver takes little
    assert (several - memory.PROCESS_GIB) * GIB >= size.preparing
    return peak, size.preparing


SURFACES = {
    "rough": "{lam_l_over_lam_s = 256}",
    "sphere": '{kind = "sphere", radius = 2.0, n = [4096, 4096], boundary = "free"}',
    "wave": '{kind = "wave", amplitude = 0.1, n = [512, 512]}',
}


@pytest.mark.parametrize(
    ("surface", "load", "precision"),
    rows("""
rough | p_star = [0.1, 1e-4, 0.1] | float32 float64 float64
rough | gap_over_h_rms = 3.0 | unknown
rough | a_r = 1e-4 | float64
sphere | force = [1e-9, 1.0] | float64 float64
sphere | force = 1e-3 | unknown
sphere | force = 1.0 | float32
wave | pressure = 0.1 | float32
"""),
)
def test_precision_of_a_plan(surface, load, precision):
    """The choice of precision = "auto", and both forecasts if it depends on the solution."""
    scene = scene_of(f"surface = {SURFACES[surface]} ; load = {{{load}}}")
    plan = plan_of(scene, surface_size(scene.surface), 4, 2, 1, 2)
    assert plan["precision"] == precision.split()
    assert ("gib_in_double" in plan) == ("unknown" in precision)
    if "unknown" in precision:
        assert plan["gib_in_double"] > plan["gib"]
        assert plan["seconds_in_double"] != plan["seconds"]
    assert plan["gib_per_node"] == pytest.approx(2 * plan["gib_per_rank"])
