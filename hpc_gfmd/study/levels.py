"""How large and how many: the series of surfaces that figures and tables share, at three levels of effort.

A series is a tuple of rows (L/lam_l, lam_l/lam_s, lam_s/a, realisations[, hurst]); seeds count from 1, so that the same ratios are
the same surfaces in every series. Levels: quick takes a minute, desk about an hour of one core, paper a cluster.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import Any

from ..errors import SceneError
from .case import Case

HURST = (0.0, 0.3, 0.5, 0.8)
HURST_GAP = (0.3, 0.5, 0.8)  # of p against gap, and of the tables of coefficients
P_LOW, P_HIGH = 0.01 / sqrt(2), 0.5 / sqrt(2)  # printed as 0.007 and 0.353
PRESSURES = {"low": P_LOW, "high": P_HIGH}
LOADS = (0.001, 0.002, 0.004, P_LOW, 0.015, 0.03, 0.06, 0.12, 0.2, P_HIGH, 0.6, 1.0, 1.5, 2.0)


@dataclass(frozen=True)
class Level:
    """The reference system (L/lam_l, lam_l/lam_s, lam_s/a) and the rows of each series; see the head of this file."""

    reference: tuple
    eps_c: tuple
    eps_f: tuple
    eps_t: tuple
    area: tuple
    gap: tuple
    loads: tuple = LOADS


LEVELS = {
    "quick": Level(
        reference=(2, 32, 2),
        eps_c=(
            (2, 32, 2, 4), (2, 32, 4, 4), (2, 32, 8, 2),
            (2, 16, 2, 4), (2, 16, 4, 4), (2, 16, 8, 4), (2, 16, 16, 2),
        ),
        eps_f=((2, 8, 2, 8), (2, 16, 2, 8), (2, 32, 2, 4), (2, 64, 2, 4), (2, 128, 2, 2)),
        eps_t=((1, 16, 2, 8), (2, 16, 2, 8), (4, 16, 2, 4), (8, 16, 2, 2), (1, 32, 2, 4), (2, 32, 2, 4), (4, 32, 2, 2)),
        area=((2, 16, 8, 2),),
        gap=((2, 8, 8, 2), (2, 16, 8, 2), (2, 32, 4, 2)),
        loads=(0.004, P_LOW, 0.03, 0.12, P_HIGH, 0.6, 1.0, 2.0),
    ),
    "desk": Level(
        reference=(2, 1024, 2),
        eps_c=(
            (2, 1024, 2, 4), (2, 1024, 4, 4), (2, 1024, 8, 1),
            (2, 128, 2, 8), (2, 128, 4, 8), (2, 128, 8, 8), (2, 128, 16, 4), (2, 128, 32, 2), (2, 128, 64, 1, (0.3, 0.8)),
        ),
        eps_f=(
            (2, 16, 2, 16), (2, 32, 2, 16), (2, 64, 2, 16), (2, 128, 2, 16), (2, 256, 2, 12), (2, 512, 2, 8),
            (2, 1024, 2, 4), (2, 2048, 2, 4), (2, 4096, 2, 1),
        ),
        eps_t=(
            (1, 256, 2, 16), (2, 256, 2, 12), (4, 256, 2, 6), (8, 256, 2, 4), (16, 256, 2, 2),
            (1, 1024, 2, 8), (2, 1024, 2, 4), (4, 1024, 2, 2),
        ),
        area=((2, 256, 8, 4),),
        gap=((2, 64, 16, 4), (2, 256, 8, 4), (2, 1024, 4, 1)),
    ),
    "paper": Level(
        reference=(2, 1024, 2),
        eps_c=(
            (2, 1024, 2, 4), (2, 1024, 4, 4), (2, 1024, 8, 4), (2, 1024, 16, 2), (2, 1024, 32, 1),
            (2, 128, 2, 4), (2, 128, 4, 4), (2, 128, 8, 4), (2, 128, 16, 4), (2, 128, 32, 4), (2, 128, 64, 2),
        ),
        eps_f=(
            (2, 16, 2, 32), (2, 32, 2, 32), (2, 64, 2, 16), (2, 128, 2, 16), (2, 256, 2, 8), (2, 512, 2, 8),
            (2, 1024, 2, 4), (2, 2048, 2, 4), (2, 4096, 2, 4), (2, 8192, 2, 2), (2, 16384, 2, 1), (2, 32768, 2, 1),
        ),
        eps_t=(
            (1, 256, 2, 16), (2, 256, 2, 8), (4, 256, 2, 8), (8, 256, 2, 4), (16, 256, 2, 4), (32, 256, 2, 2),
            (1, 1024, 2, 8), (2, 1024, 2, 4), (4, 1024, 2, 4), (8, 1024, 2, 2), (16, 1024, 2, 1),
        ),
        area=((2, 1024, 8, 2), (2, 256, 32, 2)),
        gap=((2, 64, 16, 4), (2, 256, 16, 4), (2, 1024, 16, 2), (2, 4096, 8, 1)),
    ),
}


def level_of(name: str) -> Level:
    """The Level of a name. Raises SceneError."""
    if name not in LEVELS:
        raise SceneError(f"--level: found {name!r}, allowed: {', '.join(LEVELS)}")
    return LEVELS[name]


def eps_c_series(level: str, hurst: tuple[float, ...] = HURST) -> list[Case]:
    """lam_s/a varies, at the reference lam_l/lam_s and, over more octaves, at a smaller one; the same surfaces all along."""
    return cases_of(level_of(level).eps_c, hurst, (P_LOW, P_HIGH))


def eps_f_series(level: str, hurst: tuple[float, ...] = HURST) -> list[Case]:
    """lam_l/lam_s varies, the rest as in the reference system."""
    return cases_of(level_of(level).eps_f, hurst, (P_LOW, P_HIGH))


def eps_t_series(level: str, hurst: tuple[float, ...] = HURST) -> list[Case]:
    """L/lam_l varies, at two values of lam_l/lam_s."""
    return cases_of(level_of(level).eps_t, hurst, (P_LOW, P_HIGH))


def tfc_series(level: str, hurst: tuple[float, ...] = HURST) -> list[Case]:
    """All three series, for fits of eq. tfc and limits."""
    return [case for series in (eps_c_series, eps_f_series, eps_t_series) for case in series(level, hurst)]


def pressure_series(level: str, hurst: tuple[float, ...] = HURST) -> list[Case]:
    """Sweeps over p_star for the contact area."""
    return cases_of(level_of(level).area, hurst, level_of(level).loads)


def gap_pressure_series(level: str, hurst: tuple[float, ...] = HURST_GAP) -> list[Case]:
    """Sweeps over p_star for the mean gap, at several lam_l/lam_s."""
    return cases_of(level_of(level).gap, hurst, level_of(level).loads)


def series_of(rows: dict[str, tuple], hurst: tuple[float, ...], p_star: tuple[float, ...], **more: Any) -> Callable[[str], list[Case]]:
    """A function of the level: the cases of a study with series of its own, rows[level]; hurst, p_star, more: as of cases_of."""

    def of_level(level: str) -> list[Case]:
        level_of(level)
        return cases_of(rows[level], hurst, p_star, **more)

    return of_level


def cases_of(rows: tuple, hurst: tuple[float, ...], p_star: tuple[float, ...], **more: Any) -> list[Case]:
    """The cases of a series; hurst, p_star: those of rows that name none of their own; more: other fields of the cases."""
    return [
        Case(H, L, F, C, seed, (*only[1:], p_star)[0], **more)
        for L, F, C, seeds, *only in rows
        for H in hurst
        if not only or H in only[0]
        for seed in range(1, seeds + 1)
    ]
