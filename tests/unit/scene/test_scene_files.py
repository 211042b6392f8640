"""Scene files, overrides from the command line, and names checked against registries."""

import os
import re
import tomllib
from pathlib import Path

import tomli_w
from refusal import refused
from scene_tables import FILE, scene_of, tables

import hpc_gfmd
from hpc_gfmd.scene import Scene, load_scene


def write(folder: Path, text: str | bytes, name: str = "scene.toml") -> Path:
    """Write a scene file; returns its path."""
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


BAD_FILES = [
    (b"", "empty"),
    (b" \n\t", "empty"),
    (b"\x89HDF\r\n\x1a\n", "0x89 in position 0"),
    (b"a = 1\n\xff", "0xff"),
    (b"[surface]\nkind = \n", "line 2"),
    (b"a = 1\na = 2\n", "line 2"),
    (b"\0", "not valid TOML"),
    (b"[surface]\nhurst = 0,8\n", "(decimals have a point, not a comma: 0,8)"),
    (b"a = " + b"[" * 5000, "nested too deeply"),
    (b"a = " + b"9" * 5000, "not valid TOML"),
    (b"title = 'only'", "surface: not given"),
    (b"load.p_star = 0x" + b"f" * 5000, "surface: not given"),
]


def test_bad_files_are_refused_in_one_line(tmp_path):
    for content, words in BAD_FILES:
        path = write(tmp_path, content)
        with refused(f"{re.escape(str(path))}.*{re.escape(words)}"):
            load_scene(path)


def test_unreadable_paths_are_refused_without_blocking(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    local = [tmp_path, tmp_path / "none.toml", tmp_path / "pipe.toml"]
    for path in [*local, "/dev/zero", "a\0b", "x" * 5000, ""]:
        with refused("."):
            load_scene(path)
    with refused(r"^hpc_gfmd.run: found a dict, allowed: the path of a sc"):
        hpc_gfmd.run(tables())


def test_byte_order_mark_and_windows_line_ends(tmp_path):
    text = tomli_w.dumps(tables()).replace("\n", "\r\n")
    assert load_scene(write(tmp_path, b"\xef\xbb\xbf" + text.encode())) == scene_of()


def test_surface_paths_are_relative_to_the_scene_file(tmp_path):
    (tmp_path / "in").mkdir()
    path = write(tmp_path / "in", tomli_w.dumps(tables(FILE)))
    scene = load_scene(path.relative_to(tmp_path))
    assert scene.surface.path == str(tmp_path / "in" / "z.npy")
    assert load_scene(path, ["surface.path=/data/z.npy"]).surface.path == "/data/z.npy"
    assert Scene.from_dict(tomllib.loads(scene.to_toml()), folder="/elsewhere") == scene


def test_override_replaces_another_kind_of_load(tmp_path):
    path = write(tmp_path, tomli_w.dumps(tables()))
    assert load_scene(path).load.prescribed[0] == "p_star"
    assert load_scene(path, ["load.a_r=0.1"]).load.prescribed == ("a_r", (0.1,))
    with refused(r"load\.a_rr"):
        load_scene(path, ["load.a_rr=0.1"])


def test_overrides(tmp_path):
    path = write(tmp_path, tomli_w.dumps(tables()))
    scene = load_scene(
        path,
        [
            "surface.hurst=0.3",
            "load.p_star = [0.1, 0.2]",
            "solver.name=gfmd",
            "title=a = b",
            'output.path="x.h5"',
            "solver.options.mass=2",
            "machine.threads=auto",
            "solver.low_memory=true",
            "surface.hurst=0.5",
        ],
    )
    wanted = """
        title = "a = b" ; surface.hurst = 0.5 ; load.p_star = [0.1, 0.2] ; output.path = "x.h5"
        solver = {name = "gfmd", low_memory = true, options = {mass = 2}}
        machine.threads = "auto\""""
    assert scene == scene_of(wanted)
    assert load_scene(path, ["load={pressure = 3}"]).load.pressure == (3.0,)
    assert load_scene(path, ["title="]).title == ""


BAD_OVERRIDES = [
    ("surface.hurst", "table.key=value"),
    ("=1", "table.key=value"),
    ("a..b=1", "table.key=value"),
    ("surface.hurst.x=1", "surface.hurst is no table"),
    ("surface.hurts=1", "nearest: surface.hurst"),
    ("surface.hurst=high", "found 'high'"),
    ("surface.seed=1\nx=2", "found '1\\nx=2'"),
    ("a\nb=1", "unknown key"),
    ("title=\udcff", "title: found"),
    ("surface.hurst=" + "[" * 5000, "surface.hurst: found"),
    ("surface.seed=0x" + "f" * 5000, "found a huge integer"),
]


def test_bad_overrides_are_refused_in_one_line(tmp_path):
    for override, words in BAD_OVERRIDES:
        with refused(re.escape(words)):
            load_scene(write(tmp_path, tomli_w.dumps(tables())), [override])
