"""Laws that hold on any surface: thermodynamics, reversibility, symmetries."""

import numpy as np
import pytest
from contacts import (
    EXACT,
    field,
    heights_of,
    random_heights,
    relative,
    rough,
    solve_scene,
    sweep_of,
    wave_numbers,
)

import hpc_gfmd
from hpc_gfmd.contact import all_observables

SURFACE = rough(seed=7)
LOADS = np.array([0.02, 0.024, 0.03, 0.1, 0.11, 0.4])


def numbers(step):
    return {name: f(step) for name, f in all_observables().items()}


def exact(z, p, E_star=1.0, sizes=(1.0, 1.0)):
    solution = hpc_gfmd.solve(z, p, E_star, sizes, **EXACT)
    assert solution.status == "converged"
    return solution


@pytest.mark.parametrize("sizes", [(1.0, 1.0), (1.0, 2.5)])
def test_more_load_is_more_contact(sizes):
    """With the load no point leaves the contact, the pressure falls nowhere, and the contact gets
    stiffer (Barber 1974)."""
    steps = hpc_gfmd.solve(
        random_heights((24, 20), 3),
        p_star=np.geomspace(1e-3, 3.0, 25),
        physical_sizes=sizes,
        boundary="periodic",
        observables=["stiffness"],
        **EXACT,
    )
    for before, after in zip(steps, steps[1:]):
        assert (after.pressure >= before.pressure - 1e-8 * after.p).all()
        assert (after.gap <= before.gap + 1e-8 * before.gap.max()).all()
    stiffness = steps.values("stiffness")
    is_open = np.isfinite(stiffness)  # there is no stiffness in full contact
    stiffness = stiffness[is_open]
    assert len(stiffness) > 10
    # It is the same where no point has come into contact.
    assert (np.diff(stiffness) >= -1e-9 * stiffness[1:]).all()
    assert stiffness[-1] > 100 * stiffness[0]
    p = steps.values("p")[is_open]
    gap = steps.values("gap_mean")[is_open]
    # A secant lies between the tangents at its ends.
    secants = -np.diff(p) / np.diff(gap)
    assert (secants >= stiffness[:-1] * (1 - 1e-3)).all()
    assert (secants <= stiffness[1:] * (1 + 1e-3)).all()


def test_loading_equals_unloading_and_warm_equals_cold():
    def results(loads, fresh=False):
        sweep = sweep_of(SURFACE, **EXACT)
        by_load = {}
        for p in loads:
            if fresh:
                sweep = sweep_of(SURFACE, nested=False, **EXACT)
            step = sweep.solve(p)
            by_load[p] = step.gap_mean, step.contact_points, field(step, "pressure")
        return by_load

    cold = results(LOADS, fresh=True)
    for warm in (results(LOADS), results(LOADS[::-1])):
        for p in LOADS:
            assert warm[p][0] == pytest.approx(cold[p][0], rel=1e-9)
            assert warm[p][1] == cold[p][1]
            assert relative(warm[p][2], cold[p][2]) < 1e-9


@pytest.mark.parametrize("n", [(32, 32), (27, 32), (15, 21)])
def test_translation_transposition_reflection(n):
    z = random_heights(n, seed=8)
    sizes = (1.0, 1.4)
    original = exact(z, 2.0, sizes=sizes)
    moved = exact(np.roll(z, (5, 3), (0, 1)), 2.0, sizes=sizes)
    assert relative(moved.gap, np.roll(original.gap, (5, 3), (0, 1))) < 1e-9
    turned = exact(z.T, 2.0, sizes=sizes[::-1])
    assert relative(turned.pressure, original.pressure.T) < 1e-9
    mirrored = exact(z[::-1], 2.0, sizes=sizes)
    assert relative(mirrored.pressure, original.pressure[::-1]) < 1e-9
    raised = exact(z + 100.0, 2.0, sizes=sizes)
    assert relative(raised.pressure, original.pressure) < 1e-9


@pytest.mark.parametrize("n", [(1, 24), (24, 1), (24, 5), (1, 17), (2, 24)])
def test_one_dimensional(n):
    """A profile has the solution of the surface that repeats it, and a cell of two periods that of
    one."""
    m = max(n)
    profile = random_heights((m, 1), seed=9)[:, 0]
    single = exact(profile[:, None], 1.0, sizes=(1.0, 1.0))
    z = np.broadcast_to(profile[:, None], (m, min(n)))
    z = z if n[0] == m else z.T
    solution = exact(z, 1.0)
    pressure = solution.pressure if n[0] == m else solution.pressure.T
    assert relative(pressure, np.broadcast_to(single.pressure, pressure.shape)) < 1e-9
    twice = exact(np.tile(profile[:, None], (2, 1)), 1.0, sizes=(2.0, 1.0))
    assert relative(twice.pressure[:m], single.pressure) < 1e-9


def test_finer_grids_have_the_same_surface():
    """With the same seed and a smaller a, heights agree at shared points, and the area converges
    from above."""
    coarse, middle, fine = (heights_of(rough((2, 8, k))) for k in (2, 4, 8))
    assert np.abs(middle[::2, ::2] - coarse + coarse.mean() - middle[::2, ::2].mean()).max() < 1e-10
    assert np.abs(fine[::2, ::2] - middle + middle.mean() - fine[::2, ::2].mean()).max() < 1e-10
    areas = []
    corrected = []
    for k in (2, 4, 8, 16):
        step = numbers(solve_scene(rough((2, 8, k)), 0.05))
        areas.append(step["a_r"])
        corrected.append(step["a_r_corrected"])
    assert abs(corrected[0] / areas[-1] - 1) < abs(areas[0] / areas[-1] - 1)
    assert areas[0] > areas[-1]


def test_realised_roughness():
    """h_rms and g_rms are those of the heights and their spectrum, whichever is prescribed."""
    for n_over, hurst in (((2, 16, 2), 0.8), ((1, 15, 3.0), 0.0), ((3, 4, 4), 1.0)):
        surface = rough(n_over, hurst=hurst, physical_sizes=[2.0, 2.0])
        h_rms = sweep_of(surface | {"g_rms": 0.3}).surface.h_rms
        z = heights_of(surface | {"g_rms": 0.3})
        power = np.abs(np.fft.fft2(z) / z.size) ** 2
        q = wave_numbers(z.shape, (2.0, 2.0))
        g_rms = np.sqrt(np.sum(q**2 * power))
        assert g_rms == pytest.approx(0.3, rel=1e-10)
        assert h_rms == pytest.approx(np.std(z), rel=1e-10)
        assert np.abs(heights_of(surface | {"h_rms": h_rms}) - z).max() < 1e-10
        k = q / np.pi
        low = n_over[0]
        high = n_over[0] * n_over[1]
        band = (k >= low * (1 - 1e-9)) & (k <= high * (1 + 1e-9))
        assert power[~band & (k > 0)].max(initial=0) < 1e-24 * power.max()
        assert (power[band] > 0).mean() > 0.99  # both ends included
