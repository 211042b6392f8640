"""The discretisation error of the contact area: its estimate, and where it is reported."""

import re
from dataclasses import replace

import numpy as np
import pytest
from contacts import heights_of, rough, rough_wall, solve_scene, sweep_of, sweep_over

import hpc_gfmd
from hpc_gfmd.contact.area import (
    EDGE_CORRECTION,
    OBSERVABLES,
    a_r,
    a_r_corrected,
    a_r_discretisation,
)
from hpc_gfmd.output.summary import combined_error, error_bars
from hpc_gfmd.theory import elastic

TIGHT = {"accuracy": 1e-5, "precision": "double"}


def errors_and_estimates(surface, p, grids, finest):
    """Return (error of a_r over a_r, its estimate) on each grid.

    The exact area is the edge-corrected one on the finest grid; surface(grid) makes the surface.
    """
    exact = a_r_corrected(sweep_of(surface(finest), **TIGHT).solve(p))
    pairs = []
    for grid in grids:
        contact = sweep_of(surface(grid), **TIGHT).solve(p)
        pairs.append((1 - exact / a_r(contact), a_r_discretisation(contact)))
    return np.array(pairs)


def sphere(n):
    return {"kind": "sphere", "radius": 1.0, "n": [n, n]}


@pytest.mark.parametrize("a", [0.1, 0.2])
def test_hertz(a):
    """Errors of a single circle have random signs and are within the estimates, which are not much
    too large."""
    grids = (48, 65, 96, 129, 192, 255)
    error, estimate = errors_and_estimates(sphere, 4 / 3 * a**3, grids, 512).T
    assert (np.abs(error) < estimate).all()
    assert np.sqrt(np.mean(error**2)) > 0.2 * np.sqrt(np.mean(estimate**2))
    assert (np.diff(estimate) < 0).all()


@pytest.mark.parametrize("hurst", [0.3, 0.8])
@pytest.mark.parametrize("p_star", [0.02, 0.35])
def test_rough(hurst, p_star):
    """Areas at lam_s/a = 2, 4, 8 are too large by most of the estimate, which falls by almost half
    on a grid twice as fine."""
    p = p_star * sweep_of(rough((1, 16, 2), hurst)).surface.g_rms

    def surface(lam_s_over_a):
        return rough((1, 16, lam_s_over_a), hurst)

    error, estimate = errors_and_estimates(surface, p, (2, 4, 8), 16).T
    assert ((error > 0.4 * estimate) & (error < estimate)).all()
    assert (estimate[1:] < 0.75 * estimate[:-1]).all()


@pytest.mark.parametrize("offset", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("share", [0.95, 0.98, 0.995, 0.999])
@pytest.mark.parametrize("waves", [1, 2])
def test_waves_next_to_full_contact(waves, share, offset):
    """Waves along one axis and along both open between points; all may touch on the grid."""
    x = (np.arange(24) + offset) / 24
    fine = (np.arange(384) + 0.5) / 384

    def solved(x):
        z = 0.01 * np.outer(np.cos(2 * np.pi * x), np.cos(2 * np.pi * (waves - 1) * x))
        p = share * 0.01 * np.pi * np.sqrt(waves)
        return hpc_gfmd.solve(z, p, boundary="periodic", accuracy=1e-4)

    solution = solved(x)
    missed = abs(solution.a_r - solved(fine).a_r)
    assert missed <= solution.a_r * solution.a_r_discretisation
    if solution.gap_mean == 0:
        assert "mean gap = 0," in str(solution)  # without +- 0


@pytest.mark.parametrize("a_r", [0.05, 0.2, 0.6, 0.9])
def test_pressure_at_a_prescribed_area(a_r):
    """A finer grid needs a larger pressure for the same area, at which the gap is smaller; at full
    contact the pressure is not known.
    """
    coarse, fine = (
        hpc_gfmd.solve(rough_wall((2, 16, waves)), a_r=a_r, accuracy=1e-4) for waves in (4, 32)
    )
    below, above = error_bars("p", coarse.result.steps[0])
    assert -below < fine.p / coarse.p - 1 < above < 1
    for name in ("gap_mean", "kappa", "contact_pressure_mean"):
        below, above = error_bars(name, coarse.result.steps[0])
        assert -below < fine.value(name) / coarse.value(name) - 1 < above
    assert re.search(r"p = [\d.]+ \+[\d.]+ -[\d.]+,", str(coarse))
    assert "+- ?, mean gap" in str(hpc_gfmd.solve(rough_wall((2, 16, 4)), a_r=1.0))


def test_a_profile():
    """In Westergaard's contact both edges are too far out by the same, 0.2 points on average and
    0.7 at most: the exact area is within the estimate."""
    relative_errors = []
    for n in (32, 50, 57, 64, 75, 101):
        for load in np.linspace(0.1, 0.9, 9):
            contact = solve_scene(
                {"kind": "wave", "amplitude": 0.1, "n": [n, 4]}, load * np.sqrt(2) / 2, **TIGHT
            )
            exact = 2 / np.pi * np.arcsin(np.sqrt(load))
            estimate = a_r(contact) * a_r_discretisation(contact)
            relative_errors.append((a_r(contact) - exact) / estimate)
    assert 0.8 < np.max(np.abs(relative_errors)) <= 1
    assert 0.15 < np.mean(relative_errors) < 0.4


def test_the_gap_of_a_profile_has_the_same_bar_at_any_width():
    """A bar that followed the width of 1e-5 was a fifth of the error, that of 100 larger than the
    gap."""
    rng = np.random.default_rng(2)
    k = np.arange(1, 9)
    amplitudes = 0.01 * rng.normal(size=8) / k
    phases = rng.uniform(0, 2 * np.pi, 8)

    def profile(n):
        waves = amplitudes * np.cos(2 * np.pi * np.arange(n)[:, None] / n * k + phases)
        return waves.sum(axis=1, keepdims=True)

    keys = {"boundary": "periodic", "fields": ()}
    exact = hpc_gfmd.solve(profile(2048), 0.0046, physical_sizes=(1, 1), **keys).gap_mean
    cells = [(1, 1e-5), (1, 1.0), (1, 100.0), (64, 1.0)]
    steps = [
        hpc_gfmd.solve(
            np.repeat(profile(64), n_y, axis=1), 0.0046, physical_sizes=(1, L_y), **keys
        ).result.steps[0]
        for n_y, L_y in cells
    ]
    bars = [combined_error("gap_mean", step) for step in steps]
    assert bars == pytest.approx([bars[0]] * len(cells), rel=1e-3)
    assert 0.1 < abs(exact / steps[0]["gap_mean"] - 1) / bars[0] < 1


def test_the_mean_pressure_of_a_profile():
    """Where a narrow contact is too wide by its bar, the load over it is too small by more."""
    shares = []
    for n in (24, 32, 57, 64, 101):
        wall = 0.02 * np.cos(2 * np.pi * np.arange(n) / n)[:, None]
        for load in (0.001, 0.003, 0.01, 0.03):
            p = load * 0.02 * np.pi
            solution = hpc_gfmd.solve(wall, p, boundary="periodic", **TIGHT)
            exact = p / (2 / np.pi * np.arcsin(np.sqrt(load)))
            below, above = error_bars("contact_pressure_mean", solution.steps[0])
            error = exact / solution.contact_pressure_mean - 1
            shares.append(error / above if error > 0 else -error / below)
    assert 0.5 < max(shares) <= 1


def waves(seed, shortest=5):
    """Return a function n -> heights of shape (n, n) of a piece of size 1 of a random sum of waves
    with slopes of about 0.1."""
    rng = np.random.default_rng(seed)
    k = np.arange(-shortest, shortest + 1) / 2
    q = np.hypot(k[:, None], k)
    amplitudes = np.where((q > 0) & (q <= shortest / 2), np.maximum(q, 1e-9) ** -1.8, 0)
    c = amplitudes * np.exp(2j * np.pi * rng.random(q.shape))

    def heights(n):
        along = np.exp(2j * np.pi * np.outer((np.arange(n) + 0.5) / n, k))
        return 0.01 * (along @ c @ along.T).real

    return heights


@pytest.mark.parametrize("boundary", ["mirror", "free"])
def test_areas_of_pieces_are_within_their_bars(boundary):
    """Images share the chance of how their edges lie on the grid; sides at free edges count as
    those to open points do."""
    shares = []
    for seed in range(8):
        heights = waves(seed)
        for p in (0.001, 0.01):
            keys = {"boundary": boundary, "physical_sizes": (1.0, 1.0)}
            finest = hpc_gfmd.solve(heights(256), p, **keys)
            for n in (24, 32, 48, 64):
                found = hpc_gfmd.solve(heights(n), p, **keys)
                step = found.result.steps[0]
                for name in ("a_r", "a_r_corrected"):
                    error = finest.a_r_corrected / step[name] - 1
                    below, above = error_bars(name, step)
                    shares.append(error / above if error > 0 else -error / below)
    assert 0.5 < max(shares) <= 1
    assert np.mean(shares) > 0.2


@pytest.mark.parametrize("axis", [0, 1])
def test_straight_edges_miss_alike(axis):
    """A cylinder of many equal rows (Hertz): counted as independent, half of the areas were beyond
    their bars, by up to 2.5 times."""
    x = (np.arange(128) + 0.5) / 128 - 0.5
    z = np.repeat(-(x[:, None] ** 2) / 2, 16, axis=1)
    sizes = (1.0, 0.125)
    boundary = ("free", "periodic")
    if axis == 1:
        z = z.T
        sizes = sizes[::-1]
        boundary = boundary[::-1]
    shares = []
    for force in np.linspace(0.002, 0.03, 12):
        solution = hpc_gfmd.solve(z, force, physical_sizes=sizes, boundary=boundary, fields=())
        exact = 2 * elastic.HertzLine(1.0, force, 1.0).a
        below, above = error_bars("a_r", solution.steps[0])
        error = exact / solution.a_r - 1
        shares.append(error / above if error > 0 else -error / below)
    assert 0.4 < max(shares) < 1


def test_areas_of_a_lay_along_an_axis():
    """Its edges run along the axis more than the average over directions that the correction is."""
    keys = {"hurst": 0.8, "L_over_lam_l": 1, "lam_l_over_lam_s": 8, "g_rms": 0.1}
    shares = []
    for seed in range(3):
        fine = hpc_gfmd.make_surface(
            "self-affine", lam_s_over_a=32, seed=seed, peklenik=10, angle=90, **keys
        )
        heights = [fine.heights, fine.heights[::4, ::4]]
        for p in (0.005, 0.02):
            exact, coarse = (
                hpc_gfmd.solve(z, p, physical_sizes=(1, 1), boundary="periodic") for z in heights
            )
            bar = coarse.a_r * coarse.a_r_discretisation
            shares.append((coarse.a_r - exact.a_r_corrected) / bar)
    assert 0.2 < max(shares) < 1


@pytest.mark.parametrize("points", [6, 8, 16])
def test_a_peak_between_points(points):
    """In full contact the largest pressure of a wave is known: its bar contains that however the
    wave lies on the grid, and is hardly larger where the peak is halfway between points."""
    n = 48
    amplitude = 0.01 * points / n / np.pi
    highest = 0.02  # the mean pressure, 0.01, and as much of the wave
    shares = []
    for phase in np.linspace(0, 1, 9):
        x = (np.arange(n) + phase) / points
        wave = amplitude * np.cos(2 * np.pi * x)[:, None]
        found = hpc_gfmd.solve(wave, 0.01, boundary="periodic", physical_sizes=(1.0, 1.0))
        bar = combined_error("contact_pressure_max", found.result.steps[0])
        shares.append((highest / found.contact_pressure_max - 1) / bar)
    assert shares[0] == pytest.approx(0, abs=0.02)
    assert 0.7 < max(shares) == shares[4] <= 1


def test_a_ball_is_about_the_centre():
    """So that a piece of roughness on it has the same contact on even and odd numbers of points."""
    even, odd = (
        hpc_gfmd.solve(waves(3)(n), 0.01, boundary="free", physical_sizes=(1.0, 1.0), radius=2.0)
        for n in (48, 49)
    )
    assert even.gap_mean == pytest.approx(odd.gap_mean, rel=1e-3)
    assert even.approach == pytest.approx(odd.approach, rel=1e-3)


def solve(z, sizes):
    sweep = sweep_over(z, sizes, accuracy=1e-3)
    return sweep.solve(0.1 * sweep.surface.g_rms)


def test_the_edge_correction_needs_square_pixels_and_an_isotropic_surface():
    z = heights_of(rough((2, 16, 4)))
    square = solve(z, (1.0, 1.0))
    correction = EDGE_CORRECTION * square.boundary_segments / square.N
    assert a_r_corrected(square) == a_r(square) - correction
    assert a_r_corrected(solve(z, (1.0, 1.005))) is not None
    profile = np.repeat(z[:1], len(z), 0)
    for contact in (
        solve(z[:, ::2].copy(), (1.0, 1.0)),
        solve(z, (1.0, 1.02)),
        solve(profile, (1.0, 1.0)),
        solve(profile.T.copy(), (1.0, 1.0)),
        solve(z[:1], (1.0, 1.0)),
        solve(z[:, :1], (1.0, 1.0)),
    ):
        assert OBSERVABLES["a_r_corrected"](contact) is None
        assert OBSERVABLES["kappa_corrected"](contact) is None
        assert OBSERVABLES["kappa"](contact) > 0
        assert 0 < a_r_discretisation(contact) < 1


def test_full_contact_has_no_discretisation_error():
    closed = solve_scene(rough((1, 8, 2)), 5.0, **TIGHT)
    assert a_r_discretisation(closed) == 0
    flat = hpc_gfmd.solve(np.zeros((4, 4)), 1.0)
    assert flat.a_r_discretisation == 0
    contact = solve_scene(rough((1, 8, 2)), 0.1, **TIGHT)
    lifted = replace(contact, g=contact.g + 1, certificate=replace(contact.certificate, contact=0))
    assert a_r_discretisation(lifted) == np.inf


def within_bars(surface_of, grids, finest, load, names):
    """Check that numbers on each grid differ from those on the finest one by at most their bars."""
    exact = hpc_gfmd.solve(surface_of(finest), load)
    for grid in grids:
        found = hpc_gfmd.solve(surface_of(grid), load)
        step = found.result.steps[0]
        for name in names:
            error = abs(step[name] / exact.value(name) - 1)
            assert error < combined_error(name, step) < 0.5, (grid, name)


@pytest.mark.parametrize(("hurst", "p"), [(0.3, 0.4), (0.8, 0.02), (0.8, 0.1)])
def test_gaps_and_pressures_of_finer_grids_are_within_the_bars(hurst, p):
    def surface(lam_s_over_a):
        return rough_wall((2, 32, lam_s_over_a), hurst=hurst, seed=4, h_rms=0.01)

    names = ("gap_mean", "contact_pressure_max", "contact_pressure_mean")
    within_bars(surface, (2, 4, 8), 16, p, names)


@pytest.mark.parametrize(
    ("seed", "shortest", "p"), [(1246, 3, 0.0132), (1742, 5, 0.0258), (1616, 3, 0.0185)]
)
def test_gaps_of_contacts_at_free_edges(seed, shortest, p):
    """The difference from the coarser grid vanishes by chance: it is 14 to 38 times too small."""
    keys = {"boundary": "free", "physical_sizes": (1.0, 1.0)}
    heights = waves(seed, shortest)
    exact = hpc_gfmd.solve(heights(160), p, **keys).gap_mean
    step = hpc_gfmd.solve(heights(32), p, **keys).result.steps[0]
    assert 0.3 < abs(exact / step["gap_mean"] - 1) / combined_error("gap_mean", step) < 1


def test_gaps_of_a_piece_with_free_edges():
    wall = rough_wall((2, 32, 4), seed=3, g_rms=0.1, physical_sizes=(24.0, 24.0))
    tilted = wall.heights[:128, :128] + 0.1 * np.arange(128)[:, None]

    def surface(refine):
        return hpc_gfmd.prepare_surface(
            tilted, physical_sizes=(12.0, 12.0), detrend="tilt", boundary="free", refine=refine
        )

    within_bars(surface, (1, 2, 4), 8, 0.01, ("gap_mean",))


def test_the_largest_pressure_on_a_ridge_between_mirror_images_has_no_limit():
    """Half the points add the same to that of a wedge, and the table says that."""
    pressures = []
    for n in (32, 64, 128):
        ramp = np.repeat(-0.001 * (np.arange(n)[:, None] + 0.5) / n, 4, 1)
        keys = {"boundary": ("mirror", "periodic"), "physical_sizes": (1.0, 4 / n)}
        pressed = hpc_gfmd.solve(ramp, 1e-4, **keys)
        pressures.append(pressed.contact_pressure_max)
    first, second = np.diff(pressures)
    assert first == pytest.approx(second, rel=0.01)
    assert first > 0.1 * pressures[-1]
    assert "between mirror images" in pressed.table()
    assert pressed.result.steps[0]["pressure_max_discretisation"] == np.inf
    hard = hpc_gfmd.solve(ramp, 1e-4, hardness=pressures[0] / 2, **keys)
    assert hard.result.steps[0]["pressure_max_discretisation"] == pytest.approx(0, abs=1e-6)
    refined = hpc_gfmd.prepare_surface(ramp, refine=4, **keys)  # which rounds the ridge
    rounded = hpc_gfmd.solve(refined, 1e-4)
    assert rounded.result.steps[0]["pressure_max_discretisation"] < 1
    assert "between mirror images" not in rounded.table()
    flat = hpc_gfmd.solve(0 * ramp, 1e-4, **keys)
    assert flat.result.steps[0]["pressure_max_discretisation"] == 0


def test_the_largest_pressure_of_a_narrow_patch_of_a_profile_is_not_known():
    """A peak between two points would be 1.4 times as high at most; here it is twice as high."""
    keys = {"boundary": "periodic", "physical_sizes": (1.0, 1.0), "accuracy": 1e-6}
    narrow, wide = (
        hpc_gfmd.solve(0.01 * np.cos(2 * np.pi * np.arange(n) / n)[:, None], 1e-5, **keys)
        for n in (32, 32 * 64)
    )
    assert wide.contact_pressure_max > 2 * narrow.contact_pressure_max
    assert narrow.result.steps[0]["pressure_max_discretisation"] == np.inf
    assert "one or two points of a profile" in narrow.table()
    assert wide.result.steps[0]["pressure_max_discretisation"] < 0.1


def test_where_errors_of_the_grid_stay_or_lack():
    z = heights_of(rough((2, 16, 4), 0.8))
    keys = {"boundary": "periodic", "physical_sizes": (1.0, 1.0)}
    first, near, far = hpc_gfmd.solve(z, [0.02, 0.024, 0.1], **keys).result.steps
    assert first["gap_discretisation"] == near["gap_discretisation"] != far["gap_discretisation"]
    held = hpc_gfmd.solve(z, gap_over_h_rms=0.8, **keys).result.steps[0]
    assert combined_error("gap_mean", held) == held["gap_error"]
    assert combined_error("p", held) == held["gap_discretisation"] > 1e-3
    attracted = hpc_gfmd.solve(z, 0.02, adhesion={"work": 1e-4, "range": 1e-2}, **keys)
    assert attracted.result.steps[0]["gap_discretisation"] is None
    assert "solver's alone" in attracted.table()
    assert "solver's alone" not in hpc_gfmd.solve(z, 0.02, **keys).table()
