"""Light contacts with free edges in a box: the same answers as on the whole grid."""

import numpy as np
import pytest
from contacts import field, random_heights, relative, sweep_over

import hpc_gfmd
from hpc_gfmd.driver import box as module
from hpc_gfmd.driver import starter
from hpc_gfmd.driver.starter import Starter
from hpc_gfmd.parallel import layout

N = 256
X = (np.arange(N) - 0.5 * (N - 1)) / N
ACCURACY = 1e-5


def ball(x=0.0, y=0.0):
    """Heights of a ball whose top is at (x, y) on the square from -0.5 to 0.5."""
    return -((X[:, None] - x) ** 2 + (X - y) ** 2) / 2


@pytest.fixture
def boxes(monkeypatch):
    """The boxes that were solved; they are used on small grids, too, in passes of few rows."""
    solved = []
    solve = starter.solved_in

    def noted(box, *arguments):
        solved.append(box)
        return solve(box, *arguments)

    monkeypatch.setattr(starter, "solved_in", noted)
    monkeypatch.setattr(module, "SMALLEST", 0)
    monkeypatch.setattr(layout, "ROW_BYTES", 120_000)  # the last pass has fewer rows than others
    return solved


def compare(z, p, monkeypatch):
    """Compare a contact with that on the whole grid; return both."""

    def solved():
        sweep = sweep_over(z, free=(True, True), accuracy=ACCURACY, precision="double")
        return sweep.solve(p)

    contact = solved()
    with monkeypatch.context() as patch:
        patch.setattr(Starter, "_may_be_light", lambda *_: False)
        whole = solved()
    assert contact.status == whole.status == "converged"
    for name in ("pressure", "gap"):
        assert relative(field(contact, name), field(whole, name)) < 2 * ACCURACY
    assert contact.contact_points == pytest.approx(whole.contact_points, rel=2 * ACCURACY, abs=1)
    assert contact.gap_mean == pytest.approx(whole.gap_mean, rel=2 * ACCURACY)
    assert contact.approach == pytest.approx(whole.approach, rel=10 * ACCURACY)
    assert contact.energy == pytest.approx(whole.energy, rel=10 * ACCURACY)
    return contact, whole


@pytest.mark.parametrize(
    "z",
    [ball(), ball(0.5, -0.3), ball(-0.2, 0.1) + 2e-5 * random_heights((N, N), seed=1)],
    ids=["ball", "at an edge", "rough ball"],
)
def test_a_box_gives_the_contact_of_the_whole_grid(boxes, monkeypatch, z):
    contact, whole = compare(z, 3e-5, monkeypatch)
    assert len(boxes) == 1
    assert contact.iterations <= 1  # on the whole grid, whose certificate may just miss
    assert contact.pairs < 0.8 * whole.pairs
    # with a box half the difference from every fourth point stands for that from every second one
    assert 1 / 2 < contact.gap_discretisation / whole.gap_discretisation < 2


def test_a_box_grows_until_nothing_penetrates(boxes, monkeypatch):
    """A point that coarse grids lack is not in the first box."""
    z = ball()
    z[215, 140] = 5e-5
    contact, _ = compare(z, 3e-6, monkeypatch)
    assert len(boxes) == 2
    assert contact.touching(215, 216)[0, 140]


def test_no_box_holds_contacts_that_are_far_apart(boxes, monkeypatch):
    compare(np.maximum(ball(-0.3, 0), ball(0.3, 0)), 1e-5, monkeypatch)
    assert boxes == []


@pytest.mark.parametrize("load", [{"a_r": 2e-3}, {"pressure": 3e-5, "hardness": 0.1}])
def test_sought_and_plastic_contacts_are_solved_on_the_whole_grid(boxes, load):
    """Of these a box holds the contact, too, but it has one load, and no dents beyond it."""
    how = {"physical_sizes": (1.0, 1.0), "boundary": "free"}
    contact = hpc_gfmd.solve(ball(), **how, accuracy=1e-3, precision="double", **load)
    assert contact.status == "converged"
    assert boxes == []
