"""hpc_gfmd.solve: any arguments give a solution or a SceneError of one line."""

import tomllib
import warnings
from decimal import Decimal
from types import SimpleNamespace

import numpy as np
import pytest
from contacts import random_heights
from hypothesis import given, settings
from hypothesis import strategies as st
from refusal import refused
from scene_tables import rows

import hpc_gfmd
from hpc_gfmd.util.errors import GfmdError, SceneError

Z = random_heights((8, 8))
HUGE = 10**400
REFUSED = [
    ({"E_star": HUGE}, "material.E_star: found 1000"),
    ({"E_star": 1j}, "material.E_star: found 1j"),
    ({"E_star": np.array([1.0, 2.0])}, "material.E_star: found [1.0, 2.0]"),
    ({"physical_sizes": (HUGE, 1)}, "surface.physical_sizes"),
    ({"accuracy": HUGE}, "solver.accuracy"),
    ({"pressure": None}, "load: not given"),
    ({"heights": 1e-320 * Z}, "heights that differ by"),
    ({"heights": 1e99 * Z, "physical_sizes": (1e-100, 1e-100), "E_star": 1e100}, "E_star*g_rms"),
    *[
        ({"heights": np.where(Z == Z.max(), value, Z)}, "surface: found ")
        for value in (1.7e308, -1.7e308, 1e101, np.inf, -np.inf, np.nan)
    ],
    ({"heights": np.ma.masked_less(Z, 0)}, "found"),
    ({"heights": SimpleNamespace(dims=("y", "x"))}, "heights: found axes y, x, allowed: x, y"),
    *[
        ({"heights": wrong}, "heights: found")
        for wrong in (
            *([[1, 2], [3]], [[HUGE, 1]], None, "z.npy"),
            *(Z + 1j, Z[0], Z[:0], Z[None], Z > 0, Z.astype(object)),
        )
    ],
    *[
        (tomllib.loads(arguments.replace(" ; ", "\n")), words)
        for arguments, words in rows("""
E_star = 1e-20 ; pressure = 1e90 | load: found p* = 7.41932e+108, allowed: 2.4e-17 to 1e+100
pressure = 1e-40 | load: found p* = 7.41932e-42, allowed: 2.4e-17 to 1e+100
pressure = 1e40 ; precision = "single" | solver.precision: found "single"
E_star = 1e-320 | material.E_star: found 1e-320
pressure = "20 Mpa" | 'Mpa' is no unit of pressure (did you mean "MPa"?), allowed
tol = 1e-3 | solver.tol: unknown key, nearest: solver.accuracy
shift = 0.1 | hpc_gfmd.solve: shift: unknown key, allowed: what hpc-gfmd help scene lists
heights = "z.npy" | allowed: an array, or hpc_gfmd.read_surface('z.npy')
physical_sizes = {a = 2, b = 4} | surface.physical_sizes
threads = 65536 | machine.threads: found 65536, allowed on this machine
path = "x.h5" | found path, allowed: in a scene
comm = 3 | comm: found int, allowed: a communicator
name = "gfm" | solver.name: found 'gfm', nearest: "gfmd", allowed: auto
hardness = 0.1 | load.pressure: found a pressure of 0.1, allowed: below material.hardness, 0.1
hardness = "6 GPa" | load.pressure: found 0.1, material.E_star: not given, hence 1 beside material.hardness = '6 GPa', allowed
fields = ["plastic"] | output.fields: found "plastic", allowed with material.hardness
pressure = "1 MPa" ; E_star = "2 GPa" | surface.physical_sizes: not given, hence 1 beside material.E_star = '2 GPa', allowed
pressure = "1 MPa" ; E1 = "2 GPa" ; nu1 = 0.3 | surface.physical_sizes: not given, hence 1 beside material.E1 = '2 GPa', allowed
thickness = 1 ; nu = 0.3 ; nu1 = 0.4 | found nu and nu1
boundary = ["free", "periodic"] ; accuracy = 1e-7 | solver.accuracy: found 1e-07, allowed with a free boundary: above
boundary = "free" ; distributions = ["gap_spectrum"] | 'gap_spectrum', which needs periodic boundaries, allowed: gap, patches, patches_8, pressure
observables = ["wear"] | found 'wear', not modelled
p_star = 0.1 | load: found p_star and pressure
pressure = [[0.1, 0.2], [0.3]] | load.pressure[0]: found [0.1, 0.2], allowed: a number
""")  # noqa: E501
    ],
]


def test_bad_arguments_are_refused_in_one_line():
    for arguments, words in REFUSED:
        with pytest.raises(SceneError) as caught:
            hpc_gfmd.solve(**{"heights": Z, "pressure": 0.1} | arguments)
        message = str(caught.value)
        assert words in message
        assert "allowed" in message
        assert message.isprintable()


@pytest.mark.parametrize("places", [np.s_[0, 0], np.s_[0], np.s_[:2, 1], np.s_[:, -1], np.s_[:]])
def test_infinite_heights_are_refused_without_warnings(places):
    for number in (np.inf, -np.inf):
        heights = Z.copy()
        heights[places] = number
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with refused("surface: found -?inf at"):
                hpc_gfmd.solve(heights, 0.1)
            with refused("surface.path: found -?inf at"):
                hpc_gfmd.prepare_surface(heights, detrend="tilt", boundary="mirror")
            heights[-1, -1] = -number
            with refused("surface: found -?inf at"):
                hpc_gfmd.solve(heights, 0.1, boundary="periodic")


ACCEPTED = [
    {"E_star": np.float32(2)},
    {"E_star": np.array(2)},
    {"E_star": Decimal(2)},
    {"E_star": None},
    {"pressure": np.float32(0.1)},
    {"physical_sizes": np.array([1, 2])},
    {"physical_sizes": (1.0, 1.0), "pressure": "1 MPa", "E_star": "10 MPa"},
    {"physical_sizes": [np.int64(1), 2.0]},
    {"accuracy": None, "residual": 1e-6},
    {"residual": None},
    {"threads": np.int64(2)},
    {"heights": Z.tolist()},
    {"observables": None},
    {"heights": (100 * Z).astype(np.int8)},
    {"heights": np.ma.array(Z, mask=False)},
    {"heights": Z.astype(np.longdouble)},
    {"boundary": ("free", "periodic")},
    *map(tomllib.loads, ("threads = 'auto'", "E1 = 2\nnu1 = 0.3", "thickness = 1\nnu = 0.3")),
    *map(tomllib.loads, ("low_memory = false", "max_iterations = 1_000_000_000_000")),
]


def test_accepted_arguments():
    for arguments in ACCEPTED:
        solution = hpc_gfmd.solve(**{"heights": Z, "pressure": 0.1} | arguments)
        assert solution.status == "converged", arguments


SPECIAL = [HUGE, 1e308, 5e-324, np.float32(0.5), np.int8(3), 0.5j, np.array(2.0), object()]
number = st.floats() | st.integers() | st.floats(1e-3, 1e3) | st.booleans() | st.none()
number |= st.text(max_size=3) | st.sampled_from(SPECIAL)
anything = (
    number
    | st.lists(number, max_size=3)
    | st.tuples(number, number)
    | st.dictionaries(st.text(max_size=2), number, max_size=2)
)
positive = st.floats(1e-100, 1e100)
kinds = st.sampled_from(["f4", "f2", "i1", "u8", "?", "c8", "S3", "O"]).map(
    lambda kind: (10 * Z).astype(kind)
)
PLAUSIBLE = {  # plausible values of each argument
    "heights": st.just(Z)
    | kinds
    | st.floats(1e-120, 1e120).map(lambda s: Z * s)
    | st.lists(st.lists(st.floats(), min_size=3, max_size=3), min_size=1, max_size=3),
    "pressure": positive,
    "E_star": positive,
    "physical_sizes": st.tuples(positive, positive),
    "accuracy": st.floats(1e-12, 0.5),
    "residual": st.floats(1e-300, 0.5),
    "threads": st.integers(0, 3),
    "precision": st.sampled_from(["single", "double", "auto"]),
    "low_memory": st.booleans(),
    "nested": st.booleans(),
    "options": st.just({}),
    "bogus": st.none(),
    "observables": st.just(["kappa", "stiffness"]),
    "name": st.sampled_from(["bpx", "gfmd"]),
}
changes = st.lists(st.sampled_from(list(PLAUSIBLE)), max_size=3, unique=True).flatmap(
    lambda keys: st.fixed_dictionaries({key: PLAUSIBLE[key] | anything for key in keys})
)


@settings(max_examples=250)
@given(changes, st.integers(1, 40))
def test_random_arguments_give_a_solution_or_a_refusal(changes, iterations):
    result = None
    refusal = ""
    arguments = {"heights": Z, "pressure": 0.1, "max_iterations": iterations} | changes
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            result = hpc_gfmd.solve(**arguments)
        except SceneError as error:
            refusal = str(error)
    assert (result is None) == bool(refusal)
    assert refusal.isprintable()
    # lists of loads give several solutions
    for solution in [result] if isinstance(result, hpc_gfmd.Solution) else result or ():
        if solution.status == "converged":
            for field in (solution.pressure, solution.gap, solution.displacement):
                assert np.isfinite(field).all()
            assert 0 < solution.a_r <= 1
            assert solution.pressure.mean(dtype=float) == pytest.approx(solution.p, rel=0.5)


@pytest.mark.parametrize("dtype", [np.int64, np.uint64, ">i8"])
def test_large_integers_keep_their_differences(dtype):
    heights = np.random.default_rng(0).integers(0, 100, (16, 16))
    above = heights.astype(dtype) + np.asarray(2**60, dtype)
    expected = hpc_gfmd.solve(heights, 0.5, boundary="periodic")
    for surface in (above, np.ma.masked_equal(above, 0)):
        np.testing.assert_array_equal(
            hpc_gfmd.solve(surface, 0.5, boundary="periodic").pressure, expected.pressure
        )


def test_a_map_that_does_not_fit_into_the_memory_is_refused_in_one_line(monkeypatch):
    def prepare(*arguments, **options):
        raise MemoryError("Unable to allocate 32.0 GiB")

    monkeypatch.setattr("hpc_gfmd.runs.surfaces.prepare", prepare)
    with pytest.raises(GfmdError, match=r"^preparing the surface: out of memory .*GiB\)$"):
        hpc_gfmd.prepare_surface(Z, boundary="periodic", refine=1024)
