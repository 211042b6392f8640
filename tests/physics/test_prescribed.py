"""Loads that are given by what they do: gap, area, approach, force; what they cost, and what cannot
be had."""

import re
import tomllib
from functools import partial

import numpy as np
import pytest
from contacts import EXACT, field, random_heights, relative, rough, sweep_of, sweep_over
from refusal import refused
from scene_tables import rows

import hpc_gfmd
from hpc_gfmd.bodies import body_of
from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.load_quantities import search_for
from hpc_gfmd.scene import LoadTable, Material
from hpc_gfmd.solvers import solver_names

LAYER = {"thickness": 0.05, "nu1": 0.3, "E_star": 1.0}
WALLS = {
    "periodic": (rough((2, 16, 4)), None),
    "free": (rough((2, 32, 2), boundary="free"), None),
    "layer": (rough((2, 16, 4)), LAYER),
    "free along x": (rough((2, 32, 2), boundary=["free", "periodic"]), None),
}
CASES = [
    (wall, quantity)
    for wall in WALLS
    for quantity in ("gap_mean", "a_r", "approach")
    if quantity != "approach" or wall in ("free", "layer")
]


def quantity_of(contact, quantity):
    if quantity == "a_r":
        return contact.contact_points / contact.N
    return getattr(contact, quantity)


def is_as_near_as_can_be(found, plain, wanted, accuracy):
    """Whether the area, if it is not the one that is wanted, is on a side of the jump that its note
    tells of, and no other pressure of the neighbourhood gives a nearer one."""
    area = quantity_of(found, "a_r")
    missed, points = abs(area - wanted), max(accuracy * wanted, 1 / found.N)
    if missed <= accuracy * wanted:
        return True
    before, after = map(
        float, re.search(r"a_r jumps from ([\d.]+) to ([\d.]+)", found.note).groups()
    )
    areas = [
        quantity_of(plain.solve(found.p_mean * factor), "a_r")
        for factor in np.geomspace(0.8, 1.25, 24)
    ]
    return (
        before < wanted < after
        and min(abs(area - before), abs(area - after)) <= points
        and min(areas) < wanted < max(areas)
        and min(abs(a - wanted) for a in areas) > missed - points
    )


@pytest.mark.parametrize(("wall", "quantity"), CASES)
def test_the_pressure_is_found(wall, quantity):
    """What loads gave, asked for on other paths, gives the same contacts."""
    surface, layer = WALLS[wall]
    asked = {"accuracy": 1e-3, "precision": "double"}
    plain = sweep_of(surface, layer=layer, **asked)
    steps = [
        (step, field(step, "pressure")) for p in (0.3, 0.05, 0.06, 0.2) for step in [plain.solve(p)]
    ]
    values = [quantity_of(step, quantity) for step, _ in steps]
    sweep = sweep_of(surface, layer=layer, **asked)
    pairs = []
    for value, (step, pressure) in zip(values, steps, strict=True):
        found = sweep.solve(Load(quantity, value))
        assert found.status == "converged"
        points = 1.001 / found.N if quantity == "a_r" else 0.0
        error = found.certificate.errors[0 if quantity == "a_r" else 1]
        error *= value if quantity != "approach" else found.gap_mean
        assert abs(quantity_of(found, quantity) - value) <= max(1e-3 * value - error, points)
        assert found.p_mean == pytest.approx(step.p_mean, rel=1e-2)
        assert relative(field(found, "pressure"), pressure) < 1e-2
        pairs.append(found.pairs)
    assert sum(pairs) <= 2 * sum(step.pairs for step, _ in steps)


@pytest.mark.parametrize(
    ("quantity", "boundary"), [("gap_mean", "periodic"), ("a_r", "periodic"), ("approach", "free")]
)
def test_what_it_costs(quantity, boundary):
    """FFT pairs of a sweep, all trials counted, over those of the same loads as pressures; the
    first one knows nothing yet."""
    surface, loads = rough((2, 32, 2), boundary=boundary), (0.02, 0.04, 0.08, 0.1, 0.12)
    sweeps = [sweep_of(surface, accuracy=1e-3, precision="double") for _ in range(2)]
    plain = [
        (step.pairs, quantity_of(step, quantity)) for p in loads for step in [sweeps[0].solve(p)]
    ]
    found = [sweeps[1].solve(Load(quantity, value)).pairs for _, value in plain]
    assert found[0] <= 2.5 * plain[0][0]
    assert sum(found[1:]) <= 1.5 * sum(pairs for pairs, _ in plain[1:])


WAYS = [
    {"precision": "single", "accuracy": 2e-3},
    {"precision": "single", "accuracy": 2e-3, "low_memory": True},
    {"accuracy": 1e-3, "low_memory": True},  # begins in single precision
    {"residual": 1e-9},
    *[{"name": name, "accuracy": 1e-4, "precision": "double"} for name in solver_names()],
]


@pytest.mark.parametrize("solver", WAYS)
@pytest.mark.parametrize("quantity", ["gap_mean", "a_r"])
def test_every_way(solver, quantity):
    surface, accuracy = rough((2, 16, 4)), solver.get("accuracy", 2e-3)
    point = 1.001 / 128**2 if quantity == "a_r" else 0.0
    fine, sweep = sweep_of(surface, **EXACT), sweep_of(surface, **solver)
    value = quantity_of(fine.solve(0.1), quantity)
    for target in (1.5 * value, value):
        found = sweep.solve(Load(quantity, target))
        assert found.status == "converged"
        assert quantity_of(found, quantity) == pytest.approx(target, abs=point, rel=accuracy)
    found_again = fine.solve(found.p_mean)
    assert quantity_of(found_again, quantity) == pytest.approx(target, abs=point, rel=accuracy)
    steps = 2e-3 if quantity == "a_r" else 1e-3  # a point fewer touches from 0.0998 to 0.0999 on
    assert found.p_mean == pytest.approx(0.1, rel=max(3 * accuracy, steps))


@pytest.mark.parametrize("layer", [None, LAYER])
@pytest.mark.parametrize("load", [{"gap_mean": 0}, {"gap_over_h_rms": [0.0]}, {"a_r": 1}])
def test_the_least_pressure_that_closes_the_gap(load, layer):
    sweep = sweep_of(rough((2, 8, 2)), layer=layer, **EXACT)
    step = sweep.solve(*sweep.loads(LoadTable(**load)))
    p = field(step, "pressure")
    assert step.contact_points == step.N
    assert step.gap_mean == 0
    assert 0 < p.min() < 1e-9 * p.max()
    assert p.mean() == pytest.approx(step.p_mean, rel=1e-9)


def with_edges(free, **solver):
    """A sweep over a small surface."""
    return sweep_over(0.01 * random_heights((16, 12), seed=3), free=free, **solver)


@pytest.mark.parametrize("free", [(True, True), (True, False), (False, True)])
@pytest.mark.parametrize("solver", [{"accuracy": 1e-5}, {"accuracy": 1e-3, "precision": "single"}])
def test_a_gap_that_closes_to_its_edges(free, solver):
    """At the least load that does; what it costs counts all."""
    step = with_edges(free, **solver).solve(Load("a_r", 1.0))
    p = field(step, "pressure")
    assert step.status == "converged"
    assert step.contact_points == step.N
    assert step.gap_mean == 0
    assert 0 < p.min() < solver["accuracy"] * step.p_mean
    exact = with_edges(free)
    assert exact.solve((1 + solver["accuracy"]) * step.p_mean).contact_points == step.N
    assert exact.solve((1 - solver["accuracy"]) * step.p_mean).contact_points < step.N
    assert step.pairs <= 2.5 * with_edges(free, **solver).solve(step.p_mean).pairs


@pytest.mark.parametrize(
    ("make", "gap", "accuracy", "most"),
    [
        *[
            (partial(sweep_of, rough((2, 4, 2)), layer=layer), gap, 1e-4, 2.5)
            for layer in (None, LAYER)
            for gap in (1e-4, 1e-6, 1e-8)
        ],
        *[(partial(with_edges, free), 1e-4, 1e-3, 5) for free in ((True, True), (True, False))],
    ],
)
def test_a_gap_that_nearly_closes(make, gap, accuracy, most):
    """A single point is open; the load is looked for from the one that closes it, too. most: FFT
    pairs, over those of the load as a pressure."""
    sweep = make(accuracy=accuracy)
    step = sweep.solve(*sweep.loads(LoadTable(gap_over_h_rms=gap)))
    assert step.status == "converged"
    assert step.gap_mean == pytest.approx(gap * sweep.surface.h_rms, rel=accuracy)
    assert step.pairs <= most * make(accuracy=accuracy).solve(step.p_mean).pairs


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_gaps_of_grids_that_close_on_the_way(boundary):
    """A load that is tried may close a coarse grid, or the finest: that is too much."""
    z = np.random.default_rng(400).random((32, 32)) < 0.3
    found = hpc_gfmd.solve(1.0 * z, gap_over_h_rms=[0.5, 0.1], boundary=boundary, accuracy=1e-2)
    assert {step.status for step in found} == {"converged"}


def test_a_gap_that_nothing_makes_more_accurate():
    """Next to full contact the error of free edges counts for more than is asked: that is said, and
    not tried for long."""
    closed, nearly = (with_edges((True, True), accuracy=1e-6) for _ in range(2))
    step = nearly.solve(0.99 * closed.solve(Load("a_r", 1.0)).p_mean)
    area, gap, pressure = step.certificate.errors
    assert step.status == "stagnated"
    assert area == 0
    assert pressure < 1e-6 < gap
    assert "the mean gap is known to" in step.note
    assert step.pairs < 40


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("solver", [{}, {"low_memory": True}, {"name": "gfmd"}])
def test_a_sweep_through_full_contact(boundary, solver):
    """From above or below, and again: at the same pressure."""
    sweep = sweep_of(rough((2, 8, 2), boundary=boundary), accuracy=1e-3, **solver)
    contacts = [
        sweep.solve(load) for load in sweep.loads(LoadTable(gap_over_h_rms=[0.3, 0, 0.1, 0]))
    ]
    assert all(contact.status == "converged" for contact in contacts)
    closed = [contact.contact_points == contact.N for contact in contacts]
    assert closed == [False, True, False, True]
    assert contacts[3].p_mean == pytest.approx(contacts[1].p_mean, rel=1e-3)


def test_an_area_that_jumps():
    """Four equal peaks touch all at once, and later sixteen others: what is nearer is taken, and
    that is said."""
    z = np.full((16, 16), -1.0)
    z[::8, ::8], z[4::8, ::8] = 0.0, -0.01
    for wanted, points in ((5.5 / 256, 4), (6.5 / 256, 8)):
        step = sweep_over(z, accuracy=1e-3, precision="double").solve(Load("a_r", wanted))
        assert step.status == "converged"
        assert step.contact_points == points
        assert "a_r jumps from 0.01562 to 0.03125: the nearer" in step.note


def flat_tops(points, period):
    """Squares of equal height."""
    high = np.arange(points) % period < period / 2
    return 0.01 * np.outer(high, high)


@pytest.mark.parametrize("free", [(False, False), (True, True)])
def test_areas_that_no_load_has(free):
    """Flat tops touch as a whole at any load: that is the least area, and it is said, at no cost; a
    sweep of such areas stays there."""
    fresh = partial(sweep_over, flat_tops(64, 16), free=free, accuracy=1e-3)
    sweep, loads = fresh(), []
    for wanted in (0.1, 0.02, 0.2, 1 / 4096):
        together, alone = (one.solve(Load("a_r", wanted)) for one in (sweep, fresh()))
        for step in (together, alone):
            assert step.status == "converged"
            assert step.contact_points in (1024, 1025)  # a point more or less is nothing
            assert step.note == "a_r jumps from 0 to 0.25: the least at any load"
            assert step.pairs < 40
        loads.append(together.p_mean)
    assert loads == pytest.approx([loads[0]] * 4, rel=0.1)


WAVE = np.cos(2 * np.pi * np.arange(128) / 32)
BODY = body_of(Material(**LAYER), (False, False))


@pytest.mark.parametrize(
    ("z", "how", "wanted"),
    [
        # all points of a small surface touch on the way
        (flat_tops(50, 12), {"accuracy": 3e-2}, 0.95),
        # the ground between flat tops closes in jumps that are not seen beforehand: one that two
        # loads enclose is one
        *[
            (flat_tops(64, 16), {"accuracy": 1e-3, "body": BODY}, share)
            for share in (0.3, 0.6, 0.9)
        ],
        # coarse grids have a few points on each of the equal peaks, and do not tell the load
        (0.01 * np.outer(WAVE, WAVE), {"accuracy": 1e-2}, 0.05),
        (0.01 * np.outer(WAVE, WAVE), {"accuracy": 1e-2, "free": (True, True)}, 0.01),
    ],
)
def test_an_area_that_jumps_over_what_is_wanted(z, how, wanted):
    """What is found is as near as can be."""
    sweep, plain = (sweep_over(z, **how) for _ in range(2))
    found = sweep.solve(Load("a_r", wanted))
    assert found.status == "converged"
    assert found.pairs < (12 * plain.solve(found.p_mean).pairs if "body" in how else 60)
    assert is_as_near_as_can_be(found, plain, wanted, how["accuracy"])


def test_areas_of_a_lattice():
    """Peaks that are alike, between points of the grid: the area goes in steps of many widths. What
    the search costs, over the loads that it finds."""
    x = np.arange(96) % 12 - 5.7
    found = given = 0.0
    for wanted in 0.02 + 0.03 * np.arange(9):
        sweep, plain = (sweep_over(-(x[:, None] ** 2 + x**2), accuracy=1e-4) for _ in range(2))
        step = sweep.solve(Load("a_r", wanted))
        assert step.status == "converged"
        found, given = found + step.pairs, given + plain.solve(step.p_mean).pairs
    assert found < 8 * given  # as accurate as it takes to know that points are alike


@pytest.mark.parametrize(
    ("quantity", "values"), [("a_r", (1, 4, 16, 40)), ("gap_mean", (0.1, 0.3, 0.9))]
)
@pytest.mark.parametrize("height", [5, 100])
def test_one_tall_point(height, quantity, values):
    """As dust on a scan: it carries all until it is pressed down to the rest. Alone and in lists;
    the area may jump."""
    z = random_heights((32, 32), seed=2)
    z[3, 5] = z.max() + height
    unit = 1 / z.size if quantity == "a_r" else z.max() - z.mean()
    sweep = sweep_over(z, accuracy=1e-2)
    for value in values:
        for found in (
            sweep.solve(Load(quantity, value * unit)),
            sweep_over(z, accuracy=1e-2).solve(Load(quantity, value * unit)),
        ):
            missed = abs(quantity_of(found, quantity) / (value * unit) - 1)
            assert found.status == "converged"
            assert missed < max(1e-2, 1.001 / value) or "jumps" in found.note
            assert 1e-6 < found.p_star < 1


@pytest.mark.parametrize("free", [(False, False), (True, True)])
def test_hardly_touching(free):
    """A mean gap that is but a little less than where the highest peak touches."""
    z = random_heights((16, 16), seed=3)
    gap = (z.max() - z).mean() * (1 - 1e-4)
    step = sweep_over(z, free=free, accuracy=1e-6, precision="double").solve(Load("gap_mean", gap))
    assert step.gap_mean == pytest.approx(gap, rel=1e-6)
    assert step.status == "converged"


@pytest.mark.parametrize("share", [1e-8, 1e-6, 1e-3])
def test_an_approach_that_is_next_to_nothing(share):
    """One point touches, whose force is proportional to it; coarse grids are without that point."""
    sweep = sweep_over(0.1 * random_heights((16, 16), seed=3), free=(True, True), accuracy=1e-4)
    h_rms = sweep.surface.h_rms
    step = sweep.solve(Load("approach", share * h_rms))
    assert step.status == "converged"
    assert step.contact_points == 1
    assert step.approach == pytest.approx(share * h_rms, rel=1e-4)
    assert step.p_star == pytest.approx(2.818e-3 * share, rel=1e-3)


def test_what_the_load_is_in_the_units_of_the_scene():
    sweep = sweep_of(
        rough((2, 8, 2), physical_sizes=[3.0, 3.0], boundary="free"), E_star=5.0, accuracy=1e-3
    )
    assert [load.value for load in sweep.loads(LoadTable(force=[9.0, 18.0]))] == [1.0, 2.0]
    h_rms = sweep.surface.h_rms
    loads = [
        *sweep.loads(LoadTable(gap_mean=0.5 * h_rms)),
        *sweep.loads(LoadTable(gap_over_h_rms=0.5)),
    ]
    first, second = (sweep.solve(load).p_mean for load in loads)
    assert sweep.solve(loads[0]).gap_mean == pytest.approx(0.5 * h_rms, rel=1e-3)
    assert first == pytest.approx(second, rel=1e-2)


FLAT = {"kind": "wave", "amplitude": 0.0, "n": [8, 8]}
SURFACES = {"rough": rough((2, 4, 2)), "flat": FLAT, "free": FLAT | {"boundary": "free"}}


@pytest.mark.parametrize(
    ("surface", "load", "words"),
    rows("""
rough | gap_mean = 100.0 | found 100, allowed: below
rough | gap_mean = 1e-9 | found 1e-09, allowed: above
rough | gap_over_h_rms = [0.1, 9] | found 9,
rough | gap_over_h_rms = [0.1, 1e-9] | found 1e-09, allowed: above
rough | approach = 1e-9 | found 1e-09, allowed: above
rough | a_r = 1e-6 | found 1e-06, less than half of one of 256 points, allowed: 0.00391 to 1
flat | a_r = 0.5 | found a flat surface
flat | approach = 0.5 | found a flat surface
free | gap_mean = 0.5 | found a flat surface
"""),
)
def test_what_cannot_be_had(surface, load, words):
    with refused(f"^load.{load.partition(' ')[0]}: {words}"):
        sweep_of(SURFACES[surface], **EXACT).loads(LoadTable(**tomllib.loads(load)))


def test_an_area_far_from_those_before():
    """What two loads near to each other tell of the curve says nothing of its other end: there the
    area is about twice p*."""
    sweep = sweep_over(random_heights((100, 100), seed=4), accuracy=1e-3)
    near = [
        {"p0": np.exp(x), "a_r": area, "gap_mean": 1.0, "approach": 1.0}
        for x, area in ((0.40, 0.9990), (0.44, 0.9991))
    ]
    load = Load("a_r", 4e-5)
    search = search_for(load, sweep.surface, sweep.working.heights, 1e-3, True, near)
    assert abs(search.x - np.log(2e-5)) < 3
