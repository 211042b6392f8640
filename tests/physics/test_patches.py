"""Patches, perimeter and percolation of contacts that are known."""

import numpy as np
import pytest
from counted import contact_of

import hpc_gfmd
from hpc_gfmd.contact import observables_named


def observed(contact, *names):
    return {name: f(contact) for name, f in observables_named(names).items()}


def percolates(found):
    """Whether the contact goes around along x and y, and the gap."""
    return [found[f"{name}_percolates_{axis}"] for name in ("contact", "gap") for axis in "xy"]


def mask_contact(mask, sizes=(1.0, 1.0)):
    return contact_of(np.where(mask, 0.0, 1.0), sizes=sizes)


def disc(n, radius, sizes):
    x, y = (np.arange(k) * L / k for k, L in zip(n, sizes, strict=True))
    return np.hypot(x[:, None] - 0.5 * sizes[0], y - 0.5 * sizes[1]) <= radius


@pytest.mark.parametrize("n", [(400, 400), (400, 800), (300, 900), (640, 200)])
def test_perimeter_of_a_disc(n):
    """Whatever the shape of a point; without the mean over directions it would be 4/pi of that."""
    mask = disc(n, 0.37, (1.0, 1.2))
    assert observed(mask_contact(mask, (1.0, 1.2)), "perimeter")["perimeter"] == pytest.approx(
        2 * np.pi * 0.37, rel=0.01
    )


@pytest.mark.parametrize("n", [(1, 40), (40, 1)])
def test_perimeter_of_stripes(n):
    """Two stripes as long as the cell: four edges, of full length."""
    mask = np.zeros(40, bool)
    mask[[3, 4, 5, 20]] = True
    along = 1.7 if n[0] == 1 else 0.6
    assert observed(mask_contact(mask.reshape(n), (1.7, 0.6)), "perimeter")[
        "perimeter"
    ] == pytest.approx(4 * along)


def test_patches_in_the_unit_of_area():
    mask = np.zeros((8, 10), bool)
    mask[[0, 7, 7], [3, 3, 4]] = True  # one patch across the border
    mask[[2, 3], [1, 2]] = True  # two points that share a corner
    found = observed(mask_contact(mask, (1.6, 1.0)), "patches", "patches_8")
    point = 0.2 * 0.1
    assert found == pytest.approx(
        {
            "patches": 3,
            "patch_largest": 3 * point,
            "patch_mean": 5 / 3 * point,
            "patches_8": 2,
            "patch_largest_8": 3 * point,
            "patch_mean_8": 5 / 2 * point,
        }
    )


def test_no_patch():
    found = observed(mask_contact(np.zeros((4, 5), bool)), "patches", "perimeter", "percolation")
    assert found["patches"] == found["patch_largest"] == found["perimeter"] == 0
    assert found["patch_mean"] is None
    assert percolates(found) == [False, False, True, True]


def test_percolation_of_a_stripe_with_a_corner():
    """Contact along x that hangs together by a corner stops a fluid along y that needs sides, not
    one that passes corners."""
    mask = np.zeros((9, 7), bool)
    mask[:4, 2], mask[4:, 3], mask[0, 3] = True, True, True
    found = observed(mask_contact(mask), "percolation", "percolation_8")
    assert [name for name, yes in found.items() if yes] == [
        "gap_percolates_x",
        "contact_percolates_x_8",
        "gap_percolates_x_8",
        "gap_percolates_y_8",
    ]


@pytest.mark.parametrize("turned", [False, True])
def test_a_channel_spans_that_does_not_close(turned):
    """From one edge to the other, across the border along the other axis; repeated cells would shut
    it."""
    gap = np.zeros((8, 9), bool)
    gap[:4, 1], gap[3, [0, 8, 7]], gap[3:, 7] = True, True, True
    along, across = "yx" if turned else "xy"
    found = observed(mask_contact(~gap.T if turned else ~gap), "spanning", "percolation")
    assert found.pop(f"gap_spans_{along}")
    assert not found.pop(f"gap_spans_{across}")
    assert not found["gap_percolates_x"]
    assert not found["gap_percolates_y"]


def test_a_profile_is_made_of_stripes():
    """Heights that vary along x only: the contact goes around along y, and sizes are those of whole
    stripes."""
    z = np.repeat(np.cos(2 * np.pi * np.arange(64) / 32)[:, None] * 0.02, 12, axis=1)
    found = hpc_gfmd.solve(
        z, 0.02, physical_sizes=(1.0, 0.5), observables=["patches", "perimeter", "percolation"]
    )
    assert found.observables["patches"] == 2
    assert found.observables["patch_largest"] == pytest.approx(found.a_r * 0.5 / 2)
    assert found.observables["perimeter"] == pytest.approx(4 * 0.5)
    assert percolates(found.observables) == [False, True, False, True]
