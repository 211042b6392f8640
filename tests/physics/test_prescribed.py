"""Loads prescribed by gap, area, approach or force: accuracy, cost, and impossible values."""

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
from hpc_gfmd.driver import few_points
from hpc_gfmd.driver.load import Load
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


@pytest.mark.parametrize(("wall", "quantity"), CASES)
def test_the_pressure_is_found(wall, quantity):
    """Prescribing the results of given pressures, on another path, gives the same contacts."""
    surface, layer = WALLS[wall]
    solver = {"accuracy": 1e-3, "precision": "double"}
    plain = sweep_of(surface, layer=layer, **solver)
    steps = [
        (step, field(step, "pressure")) for p in (0.3, 0.05, 0.06, 0.2) for step in [plain.solve(p)]
    ]
    values = [quantity_of(step, quantity) for step, _ in steps]
    sweep = sweep_of(surface, layer=layer, **solver)
    pairs = []
    for value, (step, pressure) in zip(values, steps, strict=True):
        contact = sweep.solve(Load(quantity, value))
        assert contact.status == "converged"
        points = 1.001 / contact.N if quantity == "a_r" else 0.0
        error = contact.certificate.errors[0 if quantity == "a_r" else 1]
        error *= value if quantity != "approach" else contact.gap_mean
        assert abs(quantity_of(contact, quantity) - value) <= max(1e-3 * value - error, points)
        assert contact.p_mean == pytest.approx(step.p_mean, rel=1e-2)
        assert relative(field(contact, "pressure"), pressure) < 1e-2
        pairs.append(contact.pairs)
    assert sum(pairs) <= 2 * sum(step.pairs for step, _ in steps)


@pytest.mark.parametrize(
    ("quantity", "boundary"), [("gap_mean", "periodic"), ("a_r", "periodic"), ("approach", "free")]
)
def test_what_it_costs(quantity, boundary):
    """Compare the FFT pairs of all trials in a sweep with those of the same loads as pressures.

    The first search of a sweep starts without any knowledge.
    """
    surface = rough((2, 32, 2), boundary=boundary)
    plain, searching = (sweep_of(surface, accuracy=1e-3, precision="double") for _ in range(2))
    contacts = [plain.solve(p) for p in (0.02, 0.04, 0.08, 0.1, 0.12)]
    values = [quantity_of(contact, quantity) for contact in contacts]
    pairs = [searching.solve(Load(quantity, value)).pairs for value in values]
    assert pairs[0] <= 2.5 * contacts[0].pairs
    assert sum(pairs[1:]) <= 1.5 * sum(contact.pairs for contact in contacts[1:])


SOLVERS = [
    {"precision": "single", "accuracy": 2e-3},
    {"precision": "single", "accuracy": 2e-3, "low_memory": True},
    {"accuracy": 1e-3, "low_memory": True},  # begins in single precision
    {"residual": 1e-9},
    *[{"name": name, "accuracy": 1e-4, "precision": "double"} for name in solver_names()],
]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("quantity", ["gap_mean", "a_r"])
def test_every_solver(solver, quantity):
    surface = rough((2, 16, 4))
    accuracy = solver.get("accuracy", 2e-3)
    point = 1.001 / 128**2 if quantity == "a_r" else 0.0
    fine = sweep_of(surface, **EXACT)
    sweep = sweep_of(surface, **solver)
    value = quantity_of(fine.solve(0.1), quantity)
    for target in (1.5 * value, value):
        contact = sweep.solve(Load(quantity, target))
        assert contact.status == "converged"
        assert quantity_of(contact, quantity) == pytest.approx(target, abs=point, rel=accuracy)
    exact = fine.solve(contact.p_mean)
    assert quantity_of(exact, quantity) == pytest.approx(target, abs=point, rel=accuracy)
    steps = 2e-3 if quantity == "a_r" else 1e-3  # a point fewer touches from 0.0998 to 0.0999 on
    assert contact.p_mean == pytest.approx(0.1, rel=max(3 * accuracy, steps))


@pytest.mark.parametrize("layer", [None, LAYER])
@pytest.mark.parametrize("load", [{"gap_mean": 0}, {"gap_over_h_rms": [0.0]}, {"a_r": 1}])
def test_the_least_pressure_that_closes_the_gap(load, layer):
    sweep = sweep_of(rough((2, 8, 2)), layer=layer, **EXACT)
    step = sweep.solve(*sweep.loads(LoadTable(**load)))
    p = field(step, "pressure")
    assert (step.iterations, step.contact_points) == (0, step.N)
    assert step.gap_mean == 0
    assert 0 < p.min() < 1e-9 * p.max()
    assert p.mean() == pytest.approx(step.p_mean, rel=1e-9)


def with_edges(free, **solver):
    """Return a sweep over a small surface with free edges."""
    return sweep_over(0.01 * random_heights((16, 12), seed=3), free=free, **solver)


@pytest.mark.parametrize("free", [(True, True), (True, False), (False, True)])
@pytest.mark.parametrize("solver", [{"accuracy": 1e-5}, {"accuracy": 1e-3, "precision": "single"}])
def test_a_gap_that_closes_to_its_edges(free, solver, monkeypatch):
    """The smallest load that closes the gap is found, at a bounded cost of all trials."""
    step = with_edges(free, **solver).solve(Load("a_r", 1.0))
    p = field(step, "pressure")
    assert step.status == "converged"
    assert step.contact_points == step.N
    assert step.gap_mean == 0
    assert 0 < p.min() < solver["accuracy"] * step.p_mean
    exact = with_edges(free)
    assert exact.solve((1 + solver["accuracy"]) * step.p_mean).contact_points == step.N
    assert exact.solve((1 - solver["accuracy"]) * step.p_mean).contact_points < step.N
    monkeypatch.setattr(few_points, "MOST", 0.0)
    assert step.pairs <= 2.5 * with_edges(free, **solver).solve(step.p_mean).pairs


@pytest.mark.parametrize(
    ("make", "gap", "accuracy"),
    [
        *[
            (partial(sweep_of, rough((2, 4, 2)), layer=layer), gap, 1e-4)
            for layer in (None, LAYER)
            for gap in (1e-4, 1e-6, 1e-8)
        ],
        *[(partial(with_edges, free), 1e-4, 1e-3) for free in ((True, True), (True, False))],
    ],
)
def test_a_gap_that_nearly_closes(make, gap, accuracy, monkeypatch):
    """With a single open point the search also starts from the load that closes the gap, as the
    same load does if it is prescribed as a pressure."""
    sweep = make(accuracy=accuracy)
    step = sweep.solve(*sweep.loads(LoadTable(gap_over_h_rms=gap)))
    assert step.status == "converged"
    assert step.gap_mean == pytest.approx(gap * sweep.surface.h_rms, rel=accuracy)
    monkeypatch.setattr(few_points, "MOST", 0.0)
    assert step.pairs <= 5 * make(accuracy=accuracy).solve(step.p_mean).pairs


def test_a_gap_that_cannot_be_more_accurate():
    """Near full contact the error of free edges exceeds the accuracy: the solver stops early with a
    note."""
    closed, nearly_closed = (with_edges((True, True), accuracy=1e-6) for _ in range(2))
    step = nearly_closed.solve(0.99 * closed.solve(Load("a_r", 1.0)).p_mean)
    area, gap, pressure = step.certificate.errors
    assert step.status == "stagnated"
    assert area == 0
    assert pressure < 1e-6 < gap
    assert "the mean gap is known to" in step.note
    assert step.pairs < 40


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("solver", [{}, {"low_memory": True}, {"name": "gfmd"}])
def test_a_sweep_through_full_contact(boundary, solver):
    """Full contact is found at the same pressure from above and below, repeatedly."""
    sweep = sweep_of(rough((2, 8, 2), boundary=boundary), accuracy=1e-3, **solver)
    contacts = [
        sweep.solve(load) for load in sweep.loads(LoadTable(gap_over_h_rms=[0.3, 0, 0.1, 0]))
    ]
    assert all(contact.status == "converged" for contact in contacts)
    closed = [contact.contact_points == contact.N for contact in contacts]
    assert closed == [False, True, False, True]
    assert contacts[3].p_mean == pytest.approx(contacts[1].p_mean, rel=1e-3)


def flat_tops(points, period):
    """Return heights with squares of equal height."""
    is_high = np.arange(points) % period < period / 2
    return 0.01 * np.outer(is_high, is_high)


@pytest.mark.parametrize("free", [(False, False), (True, True)])
def test_areas_that_no_load_has(free):
    """Flat tops touch as a whole at any load, which is the smallest area.

    A note reports it at little cost, and all such targets in a sweep give about the same load.
    """
    make_sweep = partial(sweep_over, flat_tops(64, 16), free=free, accuracy=1e-3)
    sweep = make_sweep()
    loads = []
    for target in (0.1, 0.02, 0.2, 1 / 4096):
        in_sweep = sweep.solve(Load("a_r", target))
        alone = make_sweep().solve(Load("a_r", target))
        for step in (in_sweep, alone):
            assert step.status == "converged"
            assert step.contact_points in (1024, 1025)  # a single point more does not matter
            assert step.note == "a_r jumps from 0 to 0.25: the least at any load"
            assert step.pairs < 40
        loads.append(in_sweep.p_mean)
    assert loads == pytest.approx([loads[0]] * 4, rel=0.1)


@pytest.mark.parametrize(("worn", "share"), [(0.01, 0.5), (0.05, 0.3), (0.2, 0.98)])
@pytest.mark.parametrize("accuracy", [1e-3, 1e-4])
def test_less_than_a_worn_top(worn, share, accuracy):
    """A few more points than the flat top touch down to loads a thousand times smaller."""
    z = random_heights((64, 64), seed=3)
    z = np.minimum(z, np.quantile(z, 1 - worn))
    top = np.count_nonzero(z == z.max())
    step = sweep_over(z, accuracy=accuracy).solve(Load("a_r", share * top / z.size))
    assert step.status == "converged"
    assert top <= step.contact_points <= top * (1 + accuracy) + 1
    assert "the least at any load" in step.note
    assert step.pairs < 90


@pytest.mark.parametrize("free", [(False, False), (True, True)])
def test_hardly_touching(free):
    """The mean gap is slightly less than that at which the highest peak touches."""
    z = random_heights((16, 16), seed=3)
    gap = (z.max() - z).mean() * (1 - 1e-4)
    step = sweep_over(z, free=free, accuracy=1e-6, precision="double").solve(Load("gap_mean", gap))
    assert step.gap_mean == pytest.approx(gap, rel=1e-6)
    assert step.status == "converged"


@pytest.mark.parametrize("share", [1e-8, 1e-6, 1e-3])
def test_a_tiny_approach(share):
    """One point touches, with a force proportional to the approach; coarse grids lack it."""
    sweep = sweep_over(0.1 * random_heights((16, 16), seed=3), free=(True, True), accuracy=1e-4)
    h_rms = sweep.surface.h_rms
    step = sweep.solve(Load("approach", share * h_rms))
    assert step.status == "converged"
    assert step.contact_points == 1
    assert step.approach == pytest.approx(share * h_rms, rel=1e-4)
    assert step.p_star == pytest.approx(2.818e-3 * share, rel=1e-3)


def test_units_of_loads():
    sweep = sweep_of(
        rough((2, 8, 2), physical_sizes=[3.0, 3.0], boundary="free"), E_star=5.0, accuracy=1e-3
    )
    assert [load.value for load in sweep.loads(LoadTable(force=[9.0, 18.0]))] == [1.0, 2.0]
    h_rms = sweep.surface.h_rms
    (absolute,) = sweep.loads(LoadTable(gap_mean=0.5 * h_rms))
    (relative_load,) = sweep.loads(LoadTable(gap_over_h_rms=0.5))
    contact = sweep.solve(absolute)
    assert contact.gap_mean == pytest.approx(0.5 * h_rms, rel=1e-3)
    assert sweep.solve(relative_load).p_mean == pytest.approx(contact.p_mean, rel=1e-2)


FLAT = {"kind": "wave", "amplitude": 0.0, "n": [8, 8]}
SURFACES = {"rough": rough((2, 4, 2)), "flat": FLAT, "free": FLAT | {"boundary": "free"}}


IMPOSSIBLE = rows("""
rough | gap_mean = 100.0 | found 100, allowed: below
rough | gap_mean = 1e-9 | found 1e-09, allowed: above
rough | gap_over_h_rms = [0.1, 9] | found 9,
rough | gap_over_h_rms = [0.1, 1e-9] | found 1e-09, allowed: above
rough | approach = 1e-9 | found 1e-09, allowed: above
rough | a_r = 1e-6 | found 1e-06, less than half of one of 256 points, allowed: 0.00391 to 1
flat | a_r = 0.5 | found a flat surface
flat | approach = 0.5 | found a flat surface
free | gap_mean = 0.5 | found a flat surface
""")


def test_impossible_values():
    for surface, load, words in IMPOSSIBLE:
        with refused(f"^load.{load.partition(' ')[0]}: {words}"):
            sweep_of(SURFACES[surface], **EXACT).loads(LoadTable(**tomllib.loads(load)))


@pytest.mark.parametrize("hardness", [0.05, 5.0])
@pytest.mark.parametrize("load", [{"a_r": 0.9}, {"gap_mean": 1e-4}, {"gap_mean": 1e-6}])
def test_a_hardness_that_no_pressure_reaches_changes_nothing(hardness, load):
    """On the way the search closes the gap, where no point is open and no step descends."""
    wave = hpc_gfmd.make_surface("wave", amplitude=0.005, n=(64, 64))
    plain = hpc_gfmd.solve(wave, **load)
    found = hpc_gfmd.solve(wave, hardness=hardness, **load)
    assert plain.pressure.max() < hardness
    assert found.status == plain.status == "converged"
    # one line of points more or less: the area goes in steps of 1/64
    assert found.p == pytest.approx(plain.p, rel=1e-2 if "a_r" in load else 1e-3)
    assert abs(found.a_r - plain.a_r) < 1.001 / 64


def is_nearest_area(contact, sweep, target, accuracy):
    """Return whether a contact has the target area or the nearest one that is possible.

    In the second case its note must report a jump across the target, its area must be that of one
    side of the jump, and neighbouring pressures must not give a nearer area.
    """
    area = quantity_of(contact, "a_r")
    distance = abs(area - target)
    if distance <= accuracy * target:
        return True
    tolerance = max(accuracy * target, 1 / contact.N)
    jump = re.search(r"a_r jumps from ([\d.]+) to ([\d.]+)", contact.note)
    before, after = map(float, jump.groups())
    areas = [
        quantity_of(sweep.solve(contact.p_mean * factor), "a_r")
        for factor in np.geomspace(0.8, 1.25, 24)
    ]
    return (
        before < target < after
        and min(abs(area - before), abs(area - after)) <= tolerance
        and min(areas) < target < max(areas)
        and min(abs(a - target) for a in areas) > distance - tolerance
    )


WAVE = np.cos(2 * np.pi * np.arange(128) / 32)
BODY = body_of(Material(**LAYER), (False, False))


@pytest.mark.parametrize(
    ("z", "settings", "target"),
    [
        # all points of a small surface touch at some trial load
        (flat_tops(50, 12), {"accuracy": 3e-2}, 0.95),
        # the ground between flat tops closes in unexpected jumps, each enclosed by two loads
        *[
            (flat_tops(64, 16), {"accuracy": 1e-3, "body": BODY}, share)
            for share in (0.3, 0.6, 0.9)
        ],
        # coarse grids have few points on each of the equal peaks and mislead about the load
        (0.01 * np.outer(WAVE, WAVE), {"accuracy": 1e-2}, 0.05),
        (0.01 * np.outer(WAVE, WAVE), {"accuracy": 1e-2, "free": (True, True)}, 0.01),
    ],
)
def test_an_area_that_jumps_across_the_target(z, settings, target):
    """The nearest possible area is found."""
    sweep, plain = (sweep_over(z, **settings) for _ in range(2))
    contact = sweep.solve(Load("a_r", target))
    allowed_pairs = 12 * plain.solve(contact.p_mean).pairs if "body" in settings else 60
    assert contact.status == "converged"
    assert contact.pairs < allowed_pairs
    assert is_nearest_area(contact, plain, target, settings["accuracy"])


def test_a_gap_that_no_load_holds():
    """A plate beside a groove yields as a whole before it reaches the ground of the groove."""
    z = np.zeros((16, 16))
    z[8] = -1
    solution = hpc_gfmd.solve(z, gap_mean=0.02, hardness=0.05, boundary="periodic")
    assert solution.status == "stagnated"
    assert "gap_mean jumps at this load, from " in solution.note
    assert solution.p == pytest.approx(0.05 * 15 / 16, rel=1e-6)
