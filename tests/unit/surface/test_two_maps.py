"""Two rough bodies: their height maps are added, each in its own unit."""

from pathlib import Path

import numpy as np
import pytest
from contacts import random_heights
from refusal import refused

import hpc_gfmd
from hpc_gfmd.output.read import read_result


@pytest.fixture
def maps(cli):
    first_map = random_heights((24, 20), seed=1)
    second_map = random_heights((24, 20), seed=2)
    np.save("first.npy", first_map)
    np.save("second.npy", second_map)
    np.savez("nm.npz", surface=second_map * 1e9, unit="nm", physical_sizes=[1e9, 2e9])
    np.savez("m.npz", surface=first_map, unit="m", physical_sizes=[1.0, 2.0])
    return first_map, second_map


def test_two_files_are_solved_as_their_sum(maps, cli):
    """Preparation applies to the sum, and a changed second map is another surface."""
    first_map, second_map = maps
    Path("s.toml").write_text(
        'surface = {kind = "file", path = ["first.npy", "second.npy"], physical_sizes = [1, 2],'
        ' detrend = "tilt", flip = true}\nload.pressure = 0.1\noutput.fields = ["heights",'
        ' "pressure"]\n'
    )
    cli.prints("run s.toml -q")
    of_two_files = read_result("contact.h5")
    np.save("sum.npy", first_map + second_map)
    cli.prints("run s.toml -q -o sum.h5 --set surface.path=sum.npy")
    of_sum = read_result("sum.h5")
    assert of_two_files.steps[0]["a_r"] == of_sum.steps[0]["a_r"]
    fields = [result.fields[0]["pressure"].read(0, 24) for result in (of_two_files, of_sum)]
    assert np.array_equal(*fields)
    assert of_two_files.head["heights"] == of_sum.head["heights"]
    np.save("second.npy", 2 * second_map)
    cli.prints("run s.toml -q")
    assert read_result("contact.h5").head["heights"] != of_two_files.head["heights"]


def test_maps_in_different_units(maps):
    surface = hpc_gfmd.read_surface(["m.npz", "nm.npz"])
    assert surface.heights == pytest.approx(sum(maps), rel=1e-12)
    assert surface.sizes == pytest.approx((1.0, 2.0))
    assert surface.unit == "m"


UNLIKE = [
    (
        "other.npy",
        {"physical_sizes": [1, 2]},
        "24 x 20 .* in first.npy and 20 x 24 .* in other.npy, allowed: two maps",
    ),
    ("long.npz", {}, "points, 1 x 2 m in m.npz and .* points, 1 x 3 m in long.npz"),
    (
        "m.npz",
        {"physical_sizes": [1, 2]},
        "1 x 2 without a unit in first.npy and .* 1 x 2 m in m.npz",
    ),
    ("never.npy", {"physical_sizes": [1, 2]}, "found never.npy, which is no file"),
    ("holes.npy", {"physical_sizes": [1, 2]}, r"found nan at \(0, 3\) in first.npy \+ holes.npy"),
]


def test_maps_that_do_not_match_are_refused(maps):
    np.save("other.npy", maps[1].T)
    np.save("holes.npy", np.where(np.arange(20) == 3, np.nan, maps[1]))
    np.savez("long.npz", surface=maps[1], unit="m", physical_sizes=[1.0, 3.0])
    for second_map, keys, words in UNLIKE:
        with refused(words):
            hpc_gfmd.read_surface(["first.npy" if keys else "m.npz", second_map], **keys)
