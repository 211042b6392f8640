"""The contact area at which something first happens as the load grows, of surfaces for which it is
known between two loads only."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri

from .rows import Rows

GROUPS = 20  # of surfaces, left out one after the other


def between(sweep: Rows, happens: Callable[[dict], bool], area: str) -> tuple[float, float]:
    """(area at the last load before it happens, area at the first load where it does), 0 and 1
    where there is none. sweep: the runs of a surface in the order of their loads."""
    first = next((k for k, run in enumerate(sweep) if happens(run)), len(sweep))
    areas = [0.0, *(run[area] for run in sweep), 1.0]
    return areas[first], areas[first + 1]


def middle(bounds: ArrayLike, share: float = 0.5) -> tuple[float, float]:
    """(area at which it has happened to `share` of the surfaces, standard deviation) of the normal
    distribution that is the likeliest for these bounds, shape (..., 2)."""
    low, high = np.reshape(bounds, (-1, 2)).T
    inside = (low > 0) & (high < 1)
    start = np.mean((low + high)[inside]) / 2 if inside.any() else 0.4, np.log(0.03)

    def misfit(x: np.ndarray) -> float:
        return -np.sum(
            np.log(
                np.maximum(
                    ndtr((high - x[0]) / np.exp(x[1])) - ndtr((low - x[0]) / np.exp(x[1])), 1e-12
                )
            )
        )

    mean, log = minimize(
        misfit, start, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-4}
    ).x
    return float(mean + np.exp(log) * ndtri(share)), float(np.exp(log))


def jackknife(of: Callable[[np.ndarray], ArrayLike], count: int) -> tuple[np.ndarray, np.ndarray]:
    """(of(all), its standard errors) of a function of the indices of `count` surfaces, from what
    each group of them changes."""
    everyone = np.arange(count)
    groups = np.array_split(everyone, min(count, GROUPS))
    left: Any = (
        [of(np.delete(everyone, group)) for group in groups]
        if count > 1
        else [np.full_like(of(everyone), np.nan)]
    )
    return np.asarray(of(everyone)), np.sqrt((len(groups) - 1) * np.var(left, axis=0))
