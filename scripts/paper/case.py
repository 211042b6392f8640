"""One surface and the loads on it: what a study asks of the solver."""

from dataclasses import dataclass
from functools import cached_property

from hpc_gfmd.contact import observables_named
from hpc_gfmd.scene import Scene, SelfAffine

SURFACE = ("hurst", "L_over_lam_l", "lam_l_over_lam_s", "lam_s_over_a", "seed")
DISTRIBUTION = "{}_distribution"
LARGE = (
    2**15
    # points along an axis from which a surface is solved in low memory: two cores with 24 GiB can have
    # it then
)


@dataclass(frozen=True)
class Case:
    """A self-affine surface in the cell of side 1 with g_rms = 1 and E_star = 1, and a sweep over
    p_star.

    The ratios are those of the paper: L/lam_l = 1/eps_t, lam_l/lam_s = 1/eps_f, lam_s/a = 1/eps_c.
    Cases that differ in lam_s_over_a alone are the same surface on another grid. observables,
    distributions: what is wanted of every load beyond what all have, by the names of a scene.
    """

    hurst: float
    L_over_lam_l: float
    lam_l_over_lam_s: float
    lam_s_over_a: float
    seed: int
    p_star: tuple[float, ...]
    accuracy: float = 1e-3
    observables: tuple[str, ...] = ()
    distributions: tuple[str, ...] = ()

    @property
    def n(self) -> int:
        """Points along an axis."""
        return round(self.L_over_lam_l * self.lam_l_over_lam_s * self.lam_s_over_a)

    eps_t, eps_f, eps_c = SelfAffine.eps_t, SelfAffine.eps_f, SelfAffine.eps_c  # of the same ratios

    @property
    def surface(self) -> tuple[float, ...]:
        """What makes the surface and its grid, and how accurately it is solved; cases that agree in
        it can be one sweep."""
        return (*(getattr(self, name) for name in SURFACE), self.accuracy)

    @property
    def columns(self) -> set[str]:
        """Names under which a stored load has the observables and distributions."""
        return {*observables_named(self.observables), *map(DISTRIBUTION.format, self.distributions)}

    @property
    def cost(self) -> int:
        """Grid points times loads."""
        return self.n**2 * len(self.p_star)

    @cached_property
    def _scene(self) -> Scene:
        surface = {"kind": "self-affine"} | {name: getattr(self, name) for name in SURFACE}
        solver = {"accuracy": self.accuracy, "low_memory": self.n >= LARGE}
        return Scene.from_dict(
            {"surface": surface, "load": {"p_star": list(self.p_star)}, "solver": solver}, "study"
        )

    def scene(self) -> Scene:
        """The scene.Scene of this sweep, with the default solver. Raises SceneError for ratios that
        make no grid."""
        return self._scene

    def __str__(self) -> str:
        return (
            f"H = {self.hurst:g}, L/lam_l = {self.L_over_lam_l:g}, lam_l/lam_s ="
            f" {self.lam_l_over_lam_s:g}, lam_s/a = {self.lam_s_over_a:g} (n = {self.n}), seed"
            f" {self.seed}"
        )
