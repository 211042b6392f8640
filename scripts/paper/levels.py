"""How large and how many: the series of surfaces that figures and tables share, at three levels of
effort.

A row of a series is (L/lam_l, lam_l/lam_s, lam_s/a, realisations[, H[, loads]]), of all H and loads
of the series where it names none; seeds count from 1, so that the same ratios are the same surfaces
in every series. Levels: quick takes a minute, desk about an hour of one core, paper a cluster.
"""

from collections.abc import Callable
from math import sqrt
from typing import Any

from hpc_gfmd.util.errors import SceneError

from .case import Case

LEVELS = ("quick", "desk", "paper")
HURST = (0.0, 0.3, 0.5, 0.8)
HURST_GAP = (0.3, 0.5, 0.8)  # of p against gap, and of the tables of coefficients
P_LOW, P_HIGH = 0.01 / sqrt(2), 0.5 / sqrt(2)  # printed as 0.007 and 0.353
PRESSURES = {"low": P_LOW, "high": P_HIGH}
BOTH = tuple(PRESSURES.values())
MANY = (0.001, 0.002, 0.004, P_LOW, 0.015, 0.03, 0.06, 0.12, 0.2, P_HIGH, 0.6, 1.0, 1.5, 2.0)
LOADS = {"quick": (0.004, P_LOW, 0.03, 0.12, P_HIGH, 0.6, 1.0, 2.0), "desk": MANY, "paper": MANY}

# the reference system
REFERENCE = {"quick": (2, 32, 2), "desk": (2, 1024, 2), "paper": (2, 1024, 2)}

# lam_s/a varies, at the reference lam_l/lam_s and, over more octaves, at a smaller one; the same
# surfaces all along
EPS_C = {
    "quick": (
        (2, 32, 2, 4),
        (2, 32, 4, 4),
        (2, 32, 8, 2),
        (2, 16, 2, 4),
        (2, 16, 4, 4),
        (2, 16, 8, 4),
        (2, 16, 16, 2),
    ),
    "desk": (
        (2, 1024, 2, 4),
        (2, 1024, 4, 4),
        (2, 1024, 8, 1),
        (2, 128, 2, 8),
        (2, 128, 4, 8),
        (2, 128, 8, 8),
        (2, 128, 16, 4),
        (2, 128, 32, 2),
        (2, 128, 64, 1, (0.3, 0.8)),
    ),
    "paper": (
        (2, 1024, 2, 4),
        (2, 1024, 4, 4),
        (2, 1024, 8, 4),
        (2, 1024, 16, 2),
        (2, 1024, 32, 1),
        (2, 128, 2, 4),
        (2, 128, 4, 4),
        (2, 128, 8, 4),
        (2, 128, 16, 4),
        (2, 128, 32, 4),
        (2, 128, 64, 2),
    ),
}

# lam_l/lam_s varies, the rest as in the reference system
EPS_F = {
    "quick": ((2, 8, 2, 8), (2, 16, 2, 8), (2, 32, 2, 4), (2, 64, 2, 4), (2, 128, 2, 2)),
    "desk": (
        (2, 16, 2, 16),
        (2, 32, 2, 16),
        (2, 64, 2, 16),
        (2, 128, 2, 16),
        (2, 256, 2, 12),
        (2, 512, 2, 8),
        (2, 1024, 2, 4),
        (2, 2048, 2, 4),
        (2, 4096, 2, 1),
    ),
    "paper": (
        (2, 16, 2, 32),
        (2, 32, 2, 32),
        (2, 64, 2, 16),
        (2, 128, 2, 16),
        (2, 256, 2, 8),
        (2, 512, 2, 8),
        (2, 1024, 2, 4),
        (2, 2048, 2, 4),
        (2, 4096, 2, 4),
        (2, 8192, 2, 2),
        (2, 16384, 2, 1),
        (2, 32768, 2, 1),
    ),
}

# L/lam_l varies, at two values of lam_l/lam_s
EPS_T = {
    "quick": (
        (1, 16, 2, 8),
        (2, 16, 2, 8),
        (4, 16, 2, 4),
        (8, 16, 2, 2),
        (1, 32, 2, 4),
        (2, 32, 2, 4),
        (4, 32, 2, 2),
    ),
    "desk": (
        (1, 256, 2, 16),
        (2, 256, 2, 12),
        (4, 256, 2, 6),
        (8, 256, 2, 4),
        (16, 256, 2, 2),
        (1, 1024, 2, 8),
        (2, 1024, 2, 4),
        (4, 1024, 2, 2),
    ),
    "paper": (
        (1, 256, 2, 16),
        (2, 256, 2, 8),
        (4, 256, 2, 8),
        (8, 256, 2, 4),
        (16, 256, 2, 4),
        (32, 256, 2, 2),
        (1, 1024, 2, 8),
        (2, 1024, 2, 4),
        (4, 1024, 2, 4),
        (8, 1024, 2, 2),
        (16, 1024, 2, 1),
    ),
}

# sweeps over p_star, for the contact area and, at several lam_l/lam_s, for the mean gap
AREA = {
    "quick": ((2, 16, 8, 2),),
    "desk": ((2, 256, 8, 4),),
    "paper": ((2, 1024, 8, 2), (2, 256, 32, 2)),
}
GAP = {
    "quick": ((2, 8, 8, 2), (2, 16, 8, 2), (2, 32, 4, 2)),
    "desk": ((2, 64, 16, 4), (2, 256, 8, 4), (2, 1024, 4, 1)),
    "paper": ((2, 64, 16, 4), (2, 256, 16, 4), (2, 1024, 16, 2), (2, 4096, 8, 1)),
}


def at_level(table: dict[str, Any], level: str) -> Any:
    """What a table has for a level. Raises SceneError for a level that does not exist."""
    if level not in LEVELS:
        raise SceneError(f"--level: found {level!r}, allowed: {', '.join(LEVELS)}")
    return table[level]


def series_of(
    rows: dict[str, tuple], hurst: tuple[float, ...], loads: Any, **more: Any
) -> Callable[..., list[Case]]:
    """A function of the level (and of other H): the cases of a series. loads: p_star, or {level:
    p_star}; more: other fields of the cases."""

    def series(level: str, hurst: tuple[float, ...] = hurst) -> list[Case]:
        p_star = at_level(loads, level) if isinstance(loads, dict) else loads
        return [
            Case(H, L, F, C, seed, (*only[1:], p_star)[0], **more)
            for L, F, C, seeds, *only in at_level(rows, level)
            for H in hurst
            if not only or H in only[0]
            for seed in range(1, seeds + 1)
        ]

    return series


eps_c_series, eps_f_series, eps_t_series = (
    series_of(rows, HURST, BOTH) for rows in (EPS_C, EPS_F, EPS_T)
)
pressure_series, gap_pressure_series = (
    series_of(AREA, HURST, LOADS),
    series_of(GAP, HURST_GAP, LOADS),
)


def tfc_series(level: str, hurst: tuple[float, ...] = HURST) -> list[Case]:
    """All three series of a ratio, for fits of eq. tfc and limits."""
    return [
        case
        for series in (eps_c_series, eps_f_series, eps_t_series)
        for case in series(level, hurst)
    ]
