"""The discretisation error of the contact area: its estimate, and where it is reported."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import heights_of, rough, scene_text, solve_scene, sweep_of, sweep_over

import hpc_gfmd
from hpc_gfmd.contact.area import (
    EDGE_CORRECTION,
    OBSERVABLES,
    a_r,
    a_r_corrected,
    a_r_discretisation,
)

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
    """Errors of a single circle have random signs and are within 1.5 estimates, which are not much
    too large."""
    grids = (48, 65, 96, 129, 192, 255)
    error, estimate = errors_and_estimates(sphere, 4 / 3 * a**3, grids, 512).T
    assert (np.abs(error) < 1.5 * estimate).all()
    assert np.sqrt(np.mean(error**2)) > 0.3 * np.sqrt(np.mean(estimate**2))
    assert (np.diff(estimate) < 0).all()


@pytest.mark.parametrize("hurst", [0.3, 0.8])
@pytest.mark.parametrize("p_star", [0.02, 0.35])
def test_rough(hurst, p_star):
    """Areas at lam_s/a = 2, 4, 8 are too large by about the estimate, which falls by almost half on
    a grid twice as fine."""
    p = p_star * sweep_of(rough((1, 16, 2), hurst)).surface.g_rms

    def surface(lam_s_over_a):
        return rough((1, 16, lam_s_over_a), hurst)

    error, estimate = errors_and_estimates(surface, p, (2, 4, 8), 16).T
    assert ((error > 0.55 * estimate) & (error < 1.25 * estimate)).all()
    assert (estimate[1:] < 0.75 * estimate[:-1]).all()


def test_a_profile():
    """In Westergaard's contact each edge is too far out, by 0.2 points on average and by up to 0.3
    points more or less at random."""
    relative_errors = []
    for n in (32, 50, 57, 64, 75, 101):
        for load in np.linspace(0.1, 0.9, 9):
            contact = solve_scene(
                {"kind": "wave", "amplitude": 0.1, "n": [n, 4]}, load * np.sqrt(2) / 2, **TIGHT
            )
            exact = 2 / np.pi * np.arcsin(np.sqrt(load))
            estimate = a_r(contact) * a_r_discretisation(contact)
            relative_errors.append((a_r(contact) - exact) / estimate)
    assert np.max(np.abs(relative_errors)) < 1.75  # 0.7 points at both edges
    assert 0.3 < np.mean(relative_errors) < 0.7


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


SCENE = scene_text((2, 16, 4), [0.35, 1e-4])


def test_reported_with_the_area(tmp_path, cli):
    """Tables also show the precision of each load, which differs between loads under "auto"."""
    (tmp_path / "s.toml").write_text(SCENE)
    table = cli.prints("run s.toml")
    headline = next(line for line in table.splitlines() if "points," in line)
    assert "float32 until a load needs float64" in headline
    shown = cli.prints("show contact.h5")
    steps = cli.data("show contact.h5")["steps"]
    assert [step["precision"] for step in steps] == ["float32", "float64"]
    for text in (table, shown):
        rows = [line for line in text.splitlines() if line.endswith("  converged")]
        assert ["float32" in row for row in rows] == [True, False]
        assert ["float64" in row for row in rows] == [False, True]
    errors = cli.prints("show contact.h5 --errors")
    for step in steps:
        assert f" {100 * step['a_r_discretisation']:.2g} " in errors
    solution = hpc_gfmd.solve(heights_of(rough((2, 16, 4))), 0.35)
    assert solution.a_r_discretisation == pytest.approx(steps[0]["a_r_discretisation"], rel=0.01)
    assert solution.precision == "float32"
