"""material.adhesion in a scene: keys, units, and loads that it allows."""

import pytest
from scene_tables import scene_of

ATTRACTION = "adhesion = {work = 0.1, range = 0.01}"


def test_keys_and_defaults():
    adhesion = scene_of(f"material.{ATTRACTION}").material.adhesion
    assert (adhesion.work, adhesion.range, adhesion.law) == (0.1, 0.01, "exponential")
    assert scene_of().material.adhesion is None


@pytest.mark.parametrize(
    "load",
    [
        "p_star = [0.1, -0.1, 0]",
        "pressure = [0.1, -0.1]",
        'p_star = [0.1, -0.1, 0], branch = "retraction"',
        'approach = [0.1, 0, -0.1], branch = "retraction"',
    ],
)
def test_loads_of_0_and_below(load):
    layer = "thickness = 0.1, nu1 = 0.3"
    sticky = f"load = {{{load}}} ; material = {{{ATTRACTION}, {layer}}}"
    made = scene_of(sticky)
    assert min(made.load.prescribed[1]) == -0.1


def test_a_branch_is_another_scene():
    load, branch = "load.p_star = [0.1, -0.1, 0]", 'load.branch = "retraction"'
    scenes = [scene_of(f"{text} ; material.{ATTRACTION}") for text in (load, f"{load} ; {branch}")]
    assert scenes[0].identity() != scenes[1].identity()


@pytest.mark.parametrize("work", ["50 mJ/m2", "50 mJ/m^2", "0.05 N/m", "0.05 J/m**2"])
def test_units(work):
    surface = 'kind = "wave", amplitude = "1 nm", n = [16, 16], physical_sizes = ["1 um", "1 um"]'
    material = f'E_star = "1 GPa", adhesion = {{work = "{work}", range = "2 nm"}}'
    made = scene_of(
        f'surface = {{{surface}}} ; load.pressure = "1 MPa" ; material = {{{material}}}'
    ).material.adhesion
    assert made.work == pytest.approx(0.05)
    assert made.range == pytest.approx(2e-9)
