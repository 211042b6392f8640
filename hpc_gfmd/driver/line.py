"""A curve that is nearly straight, as far as noisy readings tell it: a Kalman filter for its level
and slope at a point that moves."""

from __future__ import annotations

from dataclasses import dataclass

UNKNOWN = 0.2  # standard deviation of a slope, relative, before anything was read
BENT = 0.15  # the same of its change over a unit of length
# times the noise of a reading, where it tells the slope: errors of successive readings are alike
NOISY = 2.0


@dataclass
class Line:
    """level, slope: of the curve here; covariance: of (level, level), (level, slope), (slope,
    slope)."""

    level: float
    slope: float
    covariance: tuple[float, float, float]

    @classmethod
    def guessed(cls, level: float, slope: float, doubt: float, unknown: float = UNKNOWN) -> Line:
        """doubt: standard deviation of where the curve has that level; unknown: of the slope,
        relative."""
        return cls(level, slope, ((doubt * slope) ** 2, 0.0, (unknown * slope) ** 2))

    def read(self, level: float, noise: float, slopes: tuple[float, float]) -> None:
        """Learn that the level is about that; noise: its standard deviation; slopes: that are
        believed."""
        ll, ls, ss = self.covariance
        news, gain, gain_slope = (
            level - self.level,
            ll / (ll + noise**2),
            ls / (ll + (NOISY * noise) ** 2),
        )
        self.level += gain * news
        self.slope = min(max(self.slope + gain_slope * news, slopes[0]), slopes[1])
        self.covariance = ll * (1 - gain), ls * (1 - gain), ss - gain_slope * ls

    def move(self, by: float) -> None:
        """Go along the curve."""
        ll, ls, ss = self.covariance
        bend = (BENT * self.slope * by) ** 2
        self.level += self.slope * by
        self.covariance = ll + 2 * ls * by + (ss + bend) * by**2, ls + ss * by, ss + bend

    def way_to(self, level: float) -> float:
        """How far it is to that level."""
        return (level - self.level) / self.slope

    def doubt(self, way: float) -> float:
        """The standard deviation of where the curve has the level that it should have so far from
        here."""
        ll, ls, ss = self.covariance
        return float(max(ll + 2 * ls * way + ss * way**2, 0.0) ** 0.5 / self.slope)
