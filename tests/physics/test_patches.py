"""Patches, perimeter and percolation of prescribed contacts."""

import numpy as np
import pytest
from counted import contact_of

from hpc_gfmd.contact import observables_named


def observed(contact, *names):
    return {name: f(contact) for name, f in observables_named(names).items()}


def mask_contact(mask, sizes=(1.0, 1.0)):
    return contact_of(np.where(mask, 0.0, 1.0), sizes=sizes)


def disc(n, radius, sizes):
    x, y = (np.arange(k) * L / k for k, L in zip(n, sizes, strict=True))
    return np.hypot(x[:, None] - 0.5 * sizes[0], y - 0.5 * sizes[1]) <= radius


@pytest.mark.parametrize("n", [(400, 400), (400, 800), (300, 900), (640, 200)])
def test_perimeter_of_a_disc(n):
    """For any shape of a grid cell; a sum of cell edges would be 4/pi times as long."""
    contact = mask_contact(disc(n, 0.37, (1.0, 1.2)), (1.0, 1.2))
    perimeter = observed(contact, "perimeter")["perimeter"]
    assert perimeter == pytest.approx(2 * np.pi * 0.37, rel=0.01)


@pytest.mark.parametrize("n", [(1, 40), (40, 1)])
def test_perimeter_of_stripes(n):
    """Two stripes have four edges, each as long as the cell."""
    mask = np.zeros(40, bool)
    mask[[3, 4, 5, 20]] = True
    length = 1.7 if n[0] == 1 else 0.6
    contact = mask_contact(mask.reshape(n), (1.7, 0.6))
    assert observed(contact, "perimeter")["perimeter"] == pytest.approx(4 * length)


def test_patches_in_the_unit_of_area():
    mask = np.zeros((8, 10), bool)
    mask[[0, 7, 7], [3, 3, 4]] = True  # one patch across the border
    mask[[2, 3], [1, 2]] = True  # two points that share a corner
    values = observed(mask_contact(mask, (1.6, 1.0)), "patches", "patches_8")
    point = 0.2 * 0.1
    assert values == pytest.approx(
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
    values = observed(mask_contact(np.zeros((4, 5), bool)), "patches", "perimeter", "percolation")
    assert values["patches"] == values["patch_largest"] == values["perimeter"] == 0
    assert values["patch_mean"] is None
    percolating = [name for name, is_true in values.items() if is_true]
    assert percolating == ["gap_percolates_x", "gap_percolates_y"]


@pytest.mark.parametrize("turned", [False, True])
def test_a_channel_that_spans_but_does_not_percolate(turned):
    """It leads from edge to edge across the periodic border of the other axis; in repeated cells it
    is closed."""
    gap = np.zeros((8, 9), bool)
    gap[:4, 1] = True
    gap[3, [0, 8, 7]] = True
    gap[3:, 7] = True
    along, across = "yx" if turned else "xy"
    values = observed(mask_contact(~gap.T if turned else ~gap), "spanning", "percolation")
    assert values.pop(f"gap_spans_{along}")
    assert not values.pop(f"gap_spans_{across}")
    assert not values["gap_percolates_x"]
    assert not values["gap_percolates_y"]
