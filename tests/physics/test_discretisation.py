"""What the size of a grid point does to the contact area: estimated, and told wherever the area
is."""

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


def refined(surface, p, n, finest):
    """Of the grids n: true relative error of a_r (in units of a_r) and its estimate; truth: the
    finest grid, edge-corrected."""
    truth, found = a_r_corrected(sweep_of(surface(finest), **TIGHT).solve(p)), []
    for k in n:
        contact = sweep_of(surface(k), **TIGHT).solve(p)
        found.append((1 - truth / a_r(contact), a_r_discretisation(contact)))
    return np.array(found)


def sphere(n):
    return {"kind": "sphere", "radius": 1.0, "n": [n, n]}


@pytest.mark.parametrize("a", [0.1, 0.2])
def test_hertz(a):
    """One circle on its grid: chance, of both signs; no error beyond 1.5 estimates, and most
    estimates are not idle."""
    error, estimate = refined(sphere, 4 / 3 * a**3, (48, 65, 96, 129, 192, 255), 512).T
    assert (np.abs(error) < 1.5 * estimate).all()
    assert np.sqrt(np.mean(error**2)) > 0.3 * np.sqrt(np.mean(estimate**2))
    assert (np.diff(estimate) < 0).all()


@pytest.mark.parametrize("hurst", [0.3, 0.8])
@pytest.mark.parametrize("p_star", [0.02, 0.35])
def test_rough(hurst, p_star):
    """lam_s/a = 2, 4, 8 against 16: all too large, by what is estimated, and half as much on a grid
    twice as fine."""
    p = p_star * sweep_of(rough((1, 16, 2), hurst)).surface.g_rms
    error, estimate = refined(lambda m: rough((1, 16, m), hurst), p, (2, 4, 8), 16).T
    assert ((error > 0.55 * estimate) & (error < 1.25 * estimate)).all()
    assert (estimate[1:] < 0.75 * estimate[:-1]).all()


def test_a_profile():
    """Westergaard: an edge is 0.2 points too far out in the mean, and by chance 0.3 points more or
    less."""
    found = []
    for n in (32, 50, 57, 64, 75, 101):
        for load in np.linspace(0.1, 0.9, 9):
            contact = solve_scene(
                {"kind": "wave", "amplitude": 0.1, "n": [n, 4]}, load * np.sqrt(2) / 2, **TIGHT
            )
            truth = 2 / np.pi * np.arcsin(np.sqrt(load))
            found.append((a_r(contact) - truth) / (a_r(contact) * a_r_discretisation(contact)))
    assert np.max(np.abs(found)) < 1.75  # 0.7 points at both edges
    assert 0.3 < np.mean(found) < 0.7


def solved(z, sizes):
    sweep = sweep_over(z, sizes, accuracy=1e-3)
    return sweep.solve(0.1 * sweep.surface.g_rms)


def test_the_edge_correction_only_where_it_holds():
    z = heights_of(rough((2, 16, 4)))
    square = solved(z, (1.0, 1.0))
    assert (
        a_r_corrected(square) == a_r(square) - EDGE_CORRECTION * square.boundary_segments / square.N
    )
    assert a_r_corrected(solved(z, (1.0, 1.005))) is not None
    profile = np.repeat(z[:1], len(z), 0)
    for contact in (
        solved(z[:, ::2].copy(), (1.0, 1.0)),
        solved(z, (1.0, 1.02)),
        solved(profile, (1.0, 1.0)),
        solved(profile.T.copy(), (1.0, 1.0)),
        solved(z[:1], (1.0, 1.0)),
        solved(z[:, :1], (1.0, 1.0)),
    ):
        assert [OBSERVABLES[name](contact) for name in ("a_r_corrected", "kappa_corrected")] == [
            None,
            None,
        ]
        assert OBSERVABLES["kappa"](contact) > 0
        assert 0 < a_r_discretisation(contact) < 1


def test_nothing_to_estimate():
    assert (
        a_r_discretisation(solve_scene(rough((1, 8, 2)), 5.0, **TIGHT)) == 0
    )  # full contact has no edge
    flat = hpc_gfmd.solve(np.zeros((4, 4)), 1.0)
    assert flat.a_r_discretisation == 0
    contact = solve_scene(rough((1, 8, 2)), 0.1, **TIGHT)
    lifted = replace(contact, g=contact.g + 1, certificate=replace(contact.certificate, contact=0))
    assert a_r_discretisation(lifted) == np.inf


SCENE = scene_text((2, 16, 4), [0.35, 1e-4])


def test_told_wherever_the_area_is(tmp_path, cli):
    """With the precision that each load was solved in, which under "auto" is not one for all."""
    (tmp_path / "s.toml").write_text(SCENE)
    table = cli.prints("run s.toml")
    headline = next(line for line in table.splitlines() if "points," in line)
    assert "float32 until a load needs float64" in headline
    shown, steps = cli.prints("show contact.h5"), cli.data("show contact.h5")["steps"]
    assert [step["precision"] for step in steps] == ["float32", "float64"]
    for text in (table, shown):
        rows = [line for line in text.splitlines() if line.endswith("  converged")]
        assert ["float32" in row for row in rows] == [True, False]
        assert ["float64" in row for row in rows] == [False, True]
    errors = cli.prints("show contact.h5 --errors")
    for step in steps:
        assert f" {100 * step['a_r_discretisation']:.2g} " in errors
    found = hpc_gfmd.solve(heights_of(rough((2, 16, 4))), 0.35)
    assert found.a_r_discretisation == pytest.approx(steps[0]["a_r_discretisation"], rel=0.01)
    assert found.precision == "float32"
