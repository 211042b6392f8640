"""[surface]: the kinds of rough surfaces, heights z(r) with peaks up on the cell L_x x L_y."""

from math import inf
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from .height_maps import Bodies, Reading
from .spectrum import Anisotropy, FourierKeys, SpectrumKeys
from .table import (
    MAX_INT,
    MAX_N,
    Boundary,
    Corners,
    Height,
    Length,
    MapBoundary,
    Modes,
    Pair,
    Points,
    Positive,
    Radii,
    Ratio,
    Table,
    key,
    one_of,
)

Factor = Annotated[int, Field(ge=1, le=1024)]


CHOICES = {  # of the boundary of a map, and what the map is then
    "mirror": "a piece of a larger surface",
    "free": "a body that ends there: ball, lens, pin",
    "periodic": "the map repeats",
}
CHOICES_TEXT = ", ".join(f'"{name}" ({meaning})' for name, meaning in CHOICES.items())


def map_boundary() -> Any:
    """Return the field `boundary` of a table whose heights are measured, or any array."""
    return key(
        f"what the map is: {CHOICES_TEXT}",
        None,
        example="mirror",
        default_text="periodic where opposite edges meet, else it must be given",
    )


class SurfaceTable(Table):
    """The rigid rough surface. Keys of every kind: the cell, in the unit of the heights."""

    physical_sizes: Pair[Length] = key("lengths [L_x, L_y] of the cell", (1.0, 1.0), unit="length")
    boundary: Boundary = key("whether the cell repeats, or has free edges", "periodic")
    radius: Radii | None = key(
        "of a ball under the roughness, or [R_x, R_y]; inf: a cylinder",
        None,
        unit="length",
        example="5 mm",
    )

    @model_validator(mode="after")
    def _form_ends(self) -> Self:
        """Raise ValueError for a ball under roughness that is periodic along a curved axis."""
        row = getattr(self, "kind", "") == "sphere"  # a periodic one is one of many
        if not row and any(R < inf and not ends for R, ends in zip(self.radii, self.free)):
            raise ValueError(
                'found radius with a periodic boundary, allowed: boundary = "free", or along x or'
                " y where the radius is inf"
            )
        return self

    @property
    def aspect(self) -> float:
        """Ratio L_y/L_x of the sides of the cell."""
        return self.physical_sizes[1] / self.physical_sizes[0]

    @property
    def radii(self) -> tuple[float, float]:
        """(R_x, R_y) of the ball under the roughness or of the sphere; inf where straight."""
        radius = inf if self.radius is None else self.radius
        return radius if isinstance(radius, tuple) else (radius, radius)

    @property
    def free(self) -> tuple[bool, bool]:
        """Whether edges are free along x, along y; False for maps without a boundary here."""
        # None: a height map that has to be periodic, see surface/quality.py
        return self._ends_as("free")

    @property
    def mirrored(self) -> tuple[bool, bool]:
        """Whether the surface goes on as its mirror images along x, along y."""
        return self._ends_as("mirror")

    def _ends_as(self, side: str) -> tuple[bool, bool]:
        """Whether the boundary along x, along y is `side`."""
        along = self.boundary if isinstance(self.boundary, tuple) else (self.boundary,) * 2
        return along[0] == side, along[1] == side


class SelfAffine(Anisotropy, SurfaceTable):
    """Random self-affine roughness with wavelengths from lam_l down to lam_s, both included.

    L is L_x. The cells of the grid are square, so n_y = n_x L_y/L_x must be a whole number, too.
    The spectrum is constant between lam_l and lam_r = lam_l/lam_l_over_lam_r (1: no roll-off).
    g_rms or h_rms is the value on the grid.
    """

    kind: Literal["self-affine"]
    hurst: Annotated[float, Field(ge=0, le=1)] = key(
        "Hurst exponent H: the spectrum falls as q^(-2 - 2 H)", example=0.8
    )
    L_over_lam_l: Ratio = key("length of the cell over the longest wave length", example=2)
    lam_l_over_lam_s: Ratio = key(
        "longest over shortest wave length; n = product of the three ratios", example=64
    )
    lam_s_over_a: Annotated[float, Field(ge=2, le=1e100)] = key(
        "shortest wave length over the grid spacing a, which resolves no wave shorter than 2 a",
        example=2,
    )
    lam_l_over_lam_r: Ratio = key(
        "longest wave length over that of the roll-off, between which the spectrum is constant", 1.0
    )
    seed: Annotated[int, Field(ge=0, le=MAX_INT)] = key(
        "of the random numbers; gives the same surface on any grid", example=1
    )
    h_rms: Length | None = key("rms height, instead of g_rms", None, unit="length", example=0.01)
    g_rms: Positive | None = key(
        "rms slope",
        default_factory=lambda given: 1.0 if given.get("h_rms") is None else None,
        example=1.0,
        default_text="1, unless h_rms is given",
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        """Raise ValueError if keys contradict each other or give no surface."""
        one_of(self, "g_rms", "h_rms")
        if self.lam_l_over_lam_r > self.lam_l_over_lam_s:
            raise ValueError(
                f"found lam_l_over_lam_r = {self.lam_l_over_lam_r:g}, "
                f"allowed: up to lam_l_over_lam_s = {self.lam_l_over_lam_s:g}"
            )
        product = self.L_over_lam_l * self.lam_l_over_lam_s * self.lam_s_over_a
        _whole(product, "n = L_over_lam_l * lam_l_over_lam_s * lam_s_over_a")
        _whole(product * self.aspect, "n_y = n_x * L_y/L_x (square cells)")
        self.require_resolved(self.L_over_lam_l * self.lam_l_over_lam_s, self.n, self.aspect)
        if self.peklenik == 1 and not self._has_modes():
            raise ValueError(
                f"found no wave vector with {self.L_over_lam_l:g} <= |q| L/2pi <= "
                f"{self.L_over_lam_l * self.lam_l_over_lam_s:g}, allowed: at least one (widen "
                "lam_l_over_lam_s)"
            )
        return self

    def _has_modes(self) -> bool:
        """Whether at least one wave of the cell lies between the two cutoffs."""
        low, high = self.L_over_lam_l, self.L_over_lam_l * self.lam_l_over_lam_s
        if high >= int(low) + 1:
            return True  # the next mode along x
        low, high = low * (1 - 1e-12), high * (1 + 1e-12)
        for k_x in range(int(high) + 1):
            # the largest k_y inside the circle |k| = high
            k_y = int(self.aspect * (high**2 - k_x**2) ** 0.5) / self.aspect
            if k_x**2 + k_y**2 >= low**2:
                return True
        return False

    @property
    def n(self) -> tuple[int, int]:
        """Grid points (n_x, n_y)."""
        n_x = self.L_over_lam_l * self.lam_l_over_lam_s * self.lam_s_over_a
        return round(n_x), round(n_x * self.aspect)

    @property
    def lam_l(self) -> float:
        """Longest wavelength, in the unit of the cell."""
        return self.physical_sizes[0] / self.L_over_lam_l

    @property
    def lam_s(self) -> float:
        """Shortest wavelength, in the unit of the cell."""
        return self.lam_l / self.lam_l_over_lam_s

    @property
    def eps_t(self) -> float:
        """lam_l/L: 0 in the thermodynamic limit."""
        return 1 / self.L_over_lam_l

    @property
    def eps_f(self) -> float:
        """lam_s/lam_l: 0 in the fractal limit."""
        return 1 / self.lam_l_over_lam_s

    @property
    def eps_c(self) -> float:
        """a/lam_s: 0 in the continuum limit."""
        return 1 / self.lam_s_over_a


class WithSpectrum(SpectrumKeys, SurfaceTable):
    """Random roughness with a given power spectrum C(q): a table, or power laws.

    h_rms^2 = (1/2 pi) times the integral of C(q) q dq. Between two rows of a table, or two wave
    lengths, C is a power law; there are no waves beyond the first and the last. A table of profiles
    (dimension = 1, h_rms^2 = (1/pi) times the integral of C(q) dq) is converted to that of the
    isotropic surface which has them; it must not rise, and beyond its end goes on as it ends.
    Arrays q_x (both signs), q_y (0 or more) and C (len(q_x) x len(q_y)), in `unit`, are the
    spectrum of an anisotropic surface; between them C is linear. With h_rms or g_rms, the value on
    the grid, the spectrum is scaled.
    """

    kind: Literal["spectrum"]


class Fourier(FourierKeys, SurfaceTable):
    """A surface given by the coefficients of its Fourier series, on any grid that resolves them.

    z = sum of c exp(2 pi i (k_x x/L_x + k_y y/L_y)) over whole k_x, k_y of any sign. Of each pair
    k and -k, whose c are conjugate, one suffices. A text has the columns k_x, k_y, real and
    imaginary part of c; .npz and HDF5 files have arrays indices (m x 2) and coefficients (m). One
    complex array, numpy.fft.fft2(z)/z.size, is taken, too.
    """

    kind: Literal["fourier"]


class Wave(SurfaceTable):
    """z = A cos(2 pi k_x x/L_x) cos(2 pi k_y y/L_y).

    It is Westergaard's wave if one k is 0, and that of Johnson et al. otherwise.
    """

    kind: Literal["wave"]
    amplitude: Height = key(
        "A, half of the height from valley to peak", unit="length", example=0.01
    )
    n: Pair[Points] = key("grid points [n_x, n_y]", example=[256, 256])
    periods: Pair[Modes] = key("waves along x and y, [k_x, k_y], not both 0", (1, 0))

    @model_validator(mode="after")
    def _resolved(self) -> Self:
        """Raise ValueError for a wave without periods, or with less than two points per period."""
        if self.periods == (0, 0):
            raise ValueError(
                "found periods = [0, 0], allowed: two whole numbers from 0, not both 0"
            )
        for k, n in zip(self.periods, self.n, strict=True):
            if 2 * k > n:
                raise ValueError(
                    f"found {k} periods on {n} points, allowed: at least two points per period"
                )
        return self


class Sphere(SurfaceTable):
    """The paraboloid z = -x^2/(2 R_x) - y^2/(2 R_y) about the point (n_x // 2, n_y // 2)."""

    kind: Literal["sphere"]
    radius: Radii = key(
        "R, of curvature at the summit, or [R_x, R_y]; inf: a cylinder", unit="length", example=1.0
    )
    n: Pair[Points] = key("grid points [n_x, n_y]", example=[256, 256])


class File(Reading, SurfaceTable):  # type: ignore[misc]
    """A measured or computed height map, or the sum of two; its shape is the grid.

    x is the first index of an array, which in a text is the line number, unless the file says
    otherwise. Sizes and units are those in the file unless these keys set them; a unit that
    contradicts the file is refused. Of two scans the finer one defines the grid points, within the
    window that both cover; the other one is interpolated by cubic splines. Operations for one map
    apply to the sum of two.
    """

    kind: Literal["file"]
    bodies: Bodies | None = key(
        "instead of path: two scans of two rough bodies, each from above, of any points and sizes",
        None,
        allowed="a list of two, each the path of a height map or a table [[surface.bodies]]",
        example=["shaft.x3p", {"path": "seal.csv", "unit": "um", "shift": ["5 um", "0 um"]}],
    )
    boundary: MapBoundary | None = map_boundary()  # type: ignore[assignment]
    crop: Corners | None = key(
        "keep only this part, [x0, y0, x1, y1], plain in the unit of the sizes",
        None,
        unit="length",
        example=["0 um", "0 um", "5 um", "5 um"],
        default_text="all",
    )
    spikes: Literal["keep", "median"] = key(
        "single points 10 times farther from their neighbours than is usual: pressed as they are,"
        " or put to the median of these",
        "keep",
    )
    detrend: Literal["none", "mean", "tilt", "curvature"] = key(
        "subtract the mean, the best plane, or the best paraboloid", "none"
    )
    fill: Literal["none", "harmonic"] = key("how points without a height get one", "none")
    flip: bool = key("turn the heights over: valleys become peaks", False)
    window: Literal["none", "hann", "tukey"] = key(
        "make the map periodic by fading it out towards its edges", "none"
    )
    refine: Factor = key(
        "this many times as many points along both axes, by Fourier interpolation", 1
    )
    downsample: Factor = key(
        "only every so many-th point along both axes, after shorter waves are removed", 1
    )

    @model_validator(mode="after")
    def _one_way_to_be_periodic(self) -> Self:
        """Raise ValueError for path beside bodies, and for a window with free or mirrored edges."""
        one_of(self, "path", "bodies")
        if self.window != "none" and any((*self.free, *self.mirrored)):
            side = "free" if any(self.free) else "mirror"
            raise ValueError(
                f'found boundary = "{side}" and window = "{self.window}", allowed: one of them'
            )
        return self

    @property
    def n(self) -> None:
        """None: unknown before the file is read."""
        return None


class ArrayTable(SurfaceTable):
    """Heights that are an array in memory."""

    boundary: MapBoundary | None = map_boundary()  # type: ignore[assignment]


KINDS: dict[str, type[SurfaceTable]] = {
    "self-affine": SelfAffine,
    "spectrum": WithSpectrum,
    "fourier": Fourier,
    "wave": Wave,
    "sphere": Sphere,
    "file": File,
}
AnySurface = Annotated[
    SelfAffine | WithSpectrum | Fourier | Wave | Sphere | File, Field(discriminator="kind")
]


def _whole(value: float, what: str) -> None:
    """Raise ValueError unless a number of points (`what`) is whole and from 1 to MAX_N."""
    if not (1 <= value <= MAX_N and abs(value - round(value)) <= 1e-9 * value):
        raise ValueError(f"found {what} = {value:.10g}, allowed: a whole number from 1 to {MAX_N}")
