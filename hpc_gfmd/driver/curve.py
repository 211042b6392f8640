"""What a sweep knows of the loads before: where the search for the pressure of the next one begins."""

from math import isfinite, log

from .prescribed import SLOPES, Search

SLOPE = {"gap_mean": 0.6, "a_r": 1.0, "approach": 0.8}  # of straightened curves, before anything is known
FAR = log(5.0)  # log p0 of two loads, that have to do with each other no more
BENT = {"gap_mean": 1.0, "a_r": 0.5, "approach": 1.0}  # share of the bend of the last three loads that goes on
BEND = 0.3  # by which a slope may differ from that of the last secant, relative


class Curve:
    """What a sweep knows of the loads before, for a first guess: points, the last three of {"x": log p0, quantity: value}; slopes and
    offsets, {quantity: Search.slope and found_offsets}."""

    def __init__(self, points=(), slopes=None, offsets=None):
        self.points, self.slopes, self.offsets = list(points), dict(slopes or {}), dict(offsets or {})

    def add(self, x, contact, search=None):
        """A load that was solved: log p0, its Contact, and the Search where that found it."""
        certificate, a = contact.certificate, contact.surface.grid.a
        self.points = [*self.points[-2:], {"x": x, "a_r": contact.contact_points / contact.N, "gap_mean": certificate.gap_mean * a,
                                           "approach": certificate.approach * a}]
        if search is not None:
            self.slopes[search.quantity] = search.slope
            if search.ends:
                self.offsets[search.quantity] = search.found_offsets

    def search(self, load, surface, top, tolerance):
        """The Search for a Prescribed load on a surface.Surface; top: see Search."""
        kind, area = load.quantity, load.quantity == "a_r"
        target = load.value if area else load.value / surface.slope
        slope = self.slopes.get(kind, SLOPE[kind])
        search = Search(kind, target, tolerance, 0.0, slope, surface.grid.N, top, list(self.offsets.get(kind, ())))
        known = [(point["x"], f) for point in self.points if isfinite(f := search._straight(point[kind]))]
        if not known:
            search.x = log(target / 2) if area else log(target / max(surface.sizes))
            if kind == "gap_mean":
                search.x = -1 - 3 * load.value / surface.h_rms  # self-affine walls
            return search
        wanted, (x, f) = search._straight(target), known[-1]
        near = [point for point in known if abs(point[0] - x) < FAR or kind not in self.slopes]  # slopes elsewhere are of no use
        secants = [((x0 + x1) / 2, (f1 - f0) / (x1 - x0)) for (x0, f0), (x1, f1) in zip(near, near[1:]) if x0 != x1]
        if secants and SLOPES[0] < secants[-1][1] < SLOPES[1]:
            middle, search.slope = secants[-1]
            bend = (search.slope - secants[0][1]) / (middle - secants[0][0]) if len(secants) > 1 and middle != secants[0][0] else 0.0
            change = BENT[kind] * bend * (x + 0.5 * (wanted - f) / search.slope - middle)
            search.slope *= 1 + min(max(change / search.slope, -BEND), BEND)
        search.x = x + (wanted - f) / search.slope
        return search
