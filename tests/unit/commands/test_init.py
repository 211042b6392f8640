"""`hpc-gfmd init` writes scenes that run; `hpc-gfmd help scene` lists every key."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from contacts import heights_of, rough

import hpc_gfmd
from hpc_gfmd.commands.init import compose
from hpc_gfmd.scene import Scene, load_scene
from hpc_gfmd.scene.reference import markdown, sections, text
from hpc_gfmd.scene.surface import KINDS

ANALYTIC = [kind for kind in KINDS if kind not in ("file", "fourier")]
SIZES = {"self-affine": "surface.lam_l_over_lam_s=8", "spectrum": "surface.n=[200, 200]"}


@pytest.mark.parametrize("kind", ANALYTIC)
def test_scenes_of_all_kinds_run(tmp_path, kind, cli):
    size = SIZES.get(kind, "surface.n=[16, 16]")
    assert cli.prints("init", kind, "--set", size) == "scene.toml: hpc-gfmd run scene.toml\n"
    assert cli.prints("run scene.toml -q") == ""
    assert (tmp_path / "contact.h5").is_file()


@pytest.mark.parametrize("kind", ANALYTIC)
def test_scene_file_holds_every_key(kind):
    lines = compose(kind, Path("scene.toml"))[0].splitlines()
    of_kind = [section for section in sections() if section.kind in ("", kind)]
    table = ""
    missing_keys = {f"{s.table}.{key.name}" for s in of_kind for key in s.keys}
    for line in lines[1:]:
        table = (re.match(r"\[(\w+)\]", line) or [None, table])[1]
        if match := re.match(r"(?:# )?(\w+) = .*  # \S", line):
            missing_keys.remove(f"{table}.{match[1]}")
            tomllib.loads(line.removeprefix("# "))  # keys that are commented out are valid, too
    assert not missing_keys
    assert max(map(len, lines)) < 150


def test_scene_of_a_spectrum_runs_unchanged(tmp_path, cli):
    (tmp_path / "rough.csv").write_text("q (1/um), C (um^4)\n0.1,1\n1,1e-3\n100,1e-11\n")
    written, missing, notes, *_ = compose("rough.csv", Path("scene.toml"))
    assert not missing
    assert "waves from 62.8319 um to 62.8319 nm" in notes[0]
    for line in ('path = "rough.csv"', 'physical_sizes = ["62.9 um", "62.9 um"]', "shortest = "):
        assert f"\n{line}" in written
    (tmp_path / "scene.toml").write_text(written)
    cli.prints("run scene.toml -q --set surface.shortest='2 um' --set surface.n=[64,64]")


def tilted(sizes=(240.0, 160.0)):
    """Write map.npz, a tilted height map with a hole; sizes: stored in nm, or None."""
    x = np.linspace(0, 1, 24)
    z = np.random.default_rng(1).normal(size=(24, 16)) + 40 * x[:, None]
    z[3, 4] = np.nan
    np.savez("map.npz", z=z, **({"physical_sizes": sizes, "unit": "nm"} if sizes else {}))


def test_scene_of_a_height_map_runs_unchanged(tmp_path, cli):
    tilted()
    written, missing, notes, *_ = compose("map.npz", Path("scene.toml"))
    assert not missing
    for words in (
        "24 x 16 points, 240 nm x 160 nm, heights in nm",
        "1 points without a height",
        "% of the variance",
        "opposite edges",
        "E_star = 1 is taken",
    ):
        assert words in "".join(notes)
    for line in (
        "24 x 16 points",
        'path = "map.npz"',
        'fill = "harmonic"  .*# 1 points',
        r'detrend = "tilt"  .*# [\d.]+ % of the variance',
        r'# physical_sizes = \["240 nm", "160 nm"\]  .*as the file says',
        '# unit = "nm"  .*as the file says',
    ):
        assert re.search(line, written), line
    (tmp_path / "scene.toml").write_text(written)
    assert load_scene("scene.toml").surface.detrend == "tilt"
    for command in ("init map.npz --force", "run scene.toml -q", "plan scene.toml"):
        cli.prints(command)


X = np.arange(96)
PERIODIC = heights_of(rough((1, 32, 3)))
PART = heights_of(rough((1, 64, 3)))[:96, :96]


def spiky(z):
    rng = np.random.default_rng(2)
    return z + 20 * z.std() * rng.normal(size=z.shape) * (rng.random(z.shape) < 0.03)


@pytest.mark.parametrize(
    ("z", "chosen", "outliers"),
    [
        (PERIODIC, {}, False),
        (spiky(PERIODIC), {}, True),
        (spiky(PART), {"boundary": "mirror"}, True),
        # a step, along an axis and across
        (np.where(X < 48, 0, 5.0)[:, None] + PART, {"boundary": "mirror"}, False),
        (np.where(X[:, None] < X, 0, 5.0) + PART, {"boundary": "mirror"}, None),
        (PART + 0.1 * X, {"boundary": "mirror", "detrend": "tilt"}, False),
        (np.round(40 * PERIODIC), {}, False),
    ],
)
def test_boundary_and_detrending_are_detected(z, chosen, outliers):
    """Outliers, steps and rounded heights change neither choice."""
    np.savez("map.npz", z=z, physical_sizes=[1.0, 1.0], unit="um")
    text, _, notes, *_ = compose("map.npz", Path("a.toml"))
    surface = tomllib.loads(text)["surface"]
    assert {key: surface[key] for key in ("boundary", "detrend") if key in surface} == chosen
    assert outliers in (None, any("points stand out" in line for line in notes))


def test_spikes_are_replaced_on_request():
    """By the median of their neighbours, whatever the tilt and the holes are; all else stays."""
    clean = PART + 0.1 * X
    spikes = (np.array([5, 20, 31]), np.array([0, 17, 40]))
    z = clean.copy()
    z[spikes] += [40, -60, 90]
    holes = (np.array([50, 19, 19, 19, 20, 21]), np.array([7, 16, 17, 18, 16, 16]))
    z[holes] = np.nan  # also most neighbours of a spike
    np.savez("map.npz", z=z, physical_sizes=[1.0, 1.0], unit="um")
    keys = {"boundary": "free", "fill": "harmonic", "spikes": "median"}
    surface = hpc_gfmd.read_surface("map.npz", **keys)
    assert "3 spikes replaced by medians" in surface.prepared
    error = np.abs(1e6 * surface.heights - clean)
    error[holes] = 0
    assert error[spikes].max() < np.abs(np.diff(clean, axis=1)).max()
    error[spikes] = 0
    assert error.max() < 1e-9
    assert "points stand out" in "".join(compose("map.npz", Path("a.toml"))[2])


def test_the_boundary_of_a_piece(tmp_path, cli, monkeypatch):
    """Without a terminal "mirror" is written with all choices; a terminal is asked."""
    np.savez("map.npz", z=PART, physical_sizes=[1.0, 1.0], unit="um")
    text = cli.prints("init map.npz")
    assert all(f'boundary = "{name}"' in text for name in ("mirror", "free", "periodic"))
    assert "jump is pressed" not in text  # mirror images have none
    (line,) = [
        line for line in Path("scene.toml").read_text().splitlines() if line.startswith("boundary")
    ]
    assert re.match(r'boundary = "mirror" .*"mirror" \(a .*"free" \(a .*"periodic" \(', line)
    answers = iter(["a", "free"])
    monkeypatch.setattr("builtins.input", lambda _: next(answers))
    for stream in ("stdin", "stdout"):
        monkeypatch.setattr(f"sys.{stream}.isatty", lambda: True)
    cli.prints("init map.npz --force")
    assert load_scene("scene.toml").surface.free == (True, True)
    complaint = cli.refused("run scene.toml --set surface.mirror=true")
    assert 'surface.mirror: found true, allowed: boundary = "mirror"' in complaint


def test_a_slight_tilt_stays_with_a_hint(cli):
    """A piece of a rough surface has one of its own; who measured it knows whether to remove it."""
    x = np.linspace(-1, 1, 24)[:, None]
    z = np.random.default_rng(1).normal(size=(24, 16)) + x
    np.savez("map.npz", z=z, physical_sizes=[24.0, 16.0], unit="nm")
    hint = 'is tilt (surface.detrend = "tilt" removes it)'
    assert hint in cli.prints("init map.npz")
    assert load_scene("scene.toml").surface.detrend == "none"
    assert hint not in cli.prints("init map.npz --force --set surface.detrend=tilt")


def test_unknown_sizes_and_units_are_not_invented(cli):
    tilted(sizes=None)
    text = cli.prints("init map.npz")
    assert all(key in text for key in ("surface.physical_sizes", "surface.unit"))
    complaint = cli.refused("run scene.toml --set surface.detrend=none --set surface.fill=none")
    for lack in ("physical_sizes: not given", "unit: not given"):
        assert f"surface.{lack}" in complaint  # both at once
    assert not compose(
        "map.npz", Path("a.toml"), ['surface.physical_sizes=["3 um", "2 um"]', "surface.unit=nm"]
    )[1]


def test_what_one_of_two_scans_lacks_is_asked_for_that_one(tmp_path, cli):
    z = np.random.default_rng(0).normal(size=(8, 8))
    np.savez("complete.npz", surface=z, physical_sizes=[1.0, 1.0], unit="um")
    np.save("bare.npy", z)
    text = cli.prints("init complete.npz bare.npy")
    assert "needs surface.physical_sizes and surface.unit, which bare.npy does not say" in text
    assert (tmp_path / "scene.toml").read_text().count("TO BE GIVEN in bodies, for bare.npy") == 2
    text = cli.prints("init bare.npy bare.npy --force")
    assert "which bare.npy and bare.npy do not say" in text


def test_existing_files_and_unknown_names_are_refused(tmp_path, cli):
    (tmp_path / "scene.toml").write_text("mine")
    tilted()
    for arguments, words in (
        ("init", "which exists"),
        ("init wave -o no/a.toml", "the folder no does not exist"),
        ("init wav -o a.toml", "wav, allowed: a kind of surface "),
        ("run map.npz", "hpc-gfmd init map.npz"),
        ("show scene.toml", "allowed: a result file"),
        ("init gone.csv -o a.toml", "there is no file gone.csv"),
        ("init wave -o a.toml --set load.presure=3", "nearest: load.pressure"),
        ("init wave -o a.toml --set title=2020-01-01", "title: found datetime.date(2020"),
        ("init map.npz -o a.toml --set surface.unit=fm", "surface.unit: found 'fm', but "),
    ):
        assert words in cli.refused(arguments)
    assert (tmp_path / "scene.toml").read_text() == "mine"
    assert not (tmp_path / "a.toml").exists()
    cli.prints(
        "init --force --set load.pressure=0.1 --set solver.options.b=1.5 --set solver.residual=0.2"
        " --set 'output={path=\"x.h5\"}'"
    )
    scene = load_scene("scene.toml")
    assert (scene.load.pressure, scene.solver.options) == ((0.1,), {"b": 1.5})
    assert (scene.solver.residual, scene.output.path) == (0.2, "x.h5")
    assert scene.output.fields == ("pressure", "gap")
    cylinder = ("surface.radius=[1.0,inf]", 'surface.boundary=["free","periodic"]')
    for surface in ("sphere", "map.npz"):
        written = tomllib.loads(compose(surface, Path("a.toml"), cylinder)[0])
        assert written["surface"]["radius"] == [1, np.inf]


def test_help_describes_every_key():
    help_text = text()
    page = markdown()
    for table, field in Scene.model_fields.items():
        models = KINDS.values() if table == "surface" else [field.annotation]
        for model in models if table != "title" else ():
            for key, item in model.model_fields.items():
                assert f"\n  {key} " in help_text
                if key != "kind":
                    assert f"| `{key}` | {item.description} | " in page
                    assert item.json_schema_extra["allowed"] in page


@pytest.mark.parametrize("boundary", ["periodic", "mirror", "free"])
def test_init_and_run_give_the_same_slope(cli, boundary):
    """Whatever is beyond the edges; a jump there is part of what is pressed."""
    np.savez("map.npz", z=PART, physical_sizes=[1.0, 1.0], unit="mm")
    text = cli.prints(f"init map.npz --set surface.boundary={boundary} --set surface.detrend=tilt")
    (slope,) = re.findall(r"g_rms = ([\d.]+)$", text, re.MULTILINE)
    surface = hpc_gfmd.read_surface("map.npz", boundary=boundary, detrend="tilt")
    assert float(slope) == pytest.approx(hpc_gfmd.solve(surface, 1.0, 1.0).g_rms, rel=1e-3)
