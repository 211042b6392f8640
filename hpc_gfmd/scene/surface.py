"""[surface]: the kinds of rough walls, heights z(r) with peaks up on the periodic cell L_x x L_y."""

from pathlib import PurePath
from typing import Annotated, Literal

from pydantic import Field, model_validator

from .table import (
    LENGTH,
    MAX_INT,
    MAX_N,
    POSITIVE,
    Boundary,
    Corners,
    Height,
    Length,
    LengthUnit,
    Modes,
    Points,
    Positive,
    Ratio,
    Sizes,
    Table,
    not_both,
)
from .table import Path as PathText

SIZES = "two positive numbers [L_x, L_y]"
POINTS = f"two whole numbers [n_x, n_y] from 1 to {MAX_N}"
Factor = Annotated[int, Field(ge=1, le=1024)]
FACTOR = "a whole number from 1 to 1024"
RATIO = "a number from 1"


class Surface(Table):
    """What every kind has: the cell, in the unit of the heights."""

    physical_sizes: Sizes = Field((1.0, 1.0), description=SIZES)
    boundary: Boundary = Field("periodic", description='"periodic", "free" or one of them for each axis')

    @property
    def free(self) -> tuple[bool, bool]:
        """Whether the surface ends along x, along y."""
        if self.boundary is None:  # a height map that has to be periodic: see surface/boundary.py
            return False, False
        along = (self.boundary, self.boundary) if isinstance(self.boundary, str) else self.boundary
        return along[0] == "free", along[1] == "free"


class SelfAffine(Surface):
    """Random self-affine roughness between the wavelengths lam_l and lam_s, both included.

    L is L_x; the cells of the grid are square, so n_y = n_x L_y/L_x must be whole too. The spectrum is
    constant between lam_l and lam_r = lam_l/lam_l_over_lam_r (1: no roll-off). g_rms or h_rms is the realised
    value.
    """

    kind: Literal["self-affine"]
    hurst: Annotated[float, Field(ge=0, le=1)] = Field(description="a number from 0 to 1")
    L_over_lam_l: Ratio = Field(description=RATIO)
    lam_l_over_lam_s: Ratio = Field(description=RATIO)
    lam_s_over_a: Annotated[float, Field(ge=2, le=1e100)] = Field(
        description="a number from 2 (the grid does not resolve lam_s < 2 a)")
    lam_l_over_lam_r: Ratio = Field(1.0, description=RATIO)
    seed: Annotated[int, Field(ge=0, le=MAX_INT)] = Field(description="a whole number from 0")
    h_rms: Length | None = Field(None, description=LENGTH)
    g_rms: Positive | None = Field(default_factory=lambda given: 1.0 if given.get("h_rms") is None else None,
                                   description=POSITIVE)

    @model_validator(mode="after")
    def _consistent(self):
        not_both(self, "g_rms", "h_rms")
        if self.lam_l_over_lam_r > self.lam_l_over_lam_s:
            raise ValueError(f"found lam_l_over_lam_r = {self.lam_l_over_lam_r:g}, "
                             f"allowed: up to lam_l_over_lam_s = {self.lam_l_over_lam_s:g}")
        product = self.L_over_lam_l * self.lam_l_over_lam_s * self.lam_s_over_a
        _whole(product, "n = L_over_lam_l * lam_l_over_lam_s * lam_s_over_a")
        _whole(product * self.aspect, "n_y = n_x * L_y/L_x (square cells)")
        if not self._has_modes():
            raise ValueError(f"found no wave vector with {self.L_over_lam_l:g} <= |q| L/2pi <= "
                             f"{self.L_over_lam_l * self.lam_l_over_lam_s:g}, allowed: at least one (widen "
                             "lam_l_over_lam_s)")
        return self

    def _has_modes(self) -> bool:
        low, high = self.L_over_lam_l, self.L_over_lam_l * self.lam_l_over_lam_s
        if high >= int(low) + 1:
            return True     # the next mode along x
        low, high = low * (1 - 1e-12), high * (1 + 1e-12)
        for k_x in range(int(high) + 1):
            # the largest k_y inside the circle |k| = high
            k_y = int(self.aspect * (high**2 - k_x**2)**0.5) / self.aspect
            if k_x**2 + k_y**2 >= low**2:
                return True
        return False

    @property
    def aspect(self) -> float:
        """L_y/L_x."""
        return self.physical_sizes[1] / self.physical_sizes[0]

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
    def lam_r(self) -> float:
        """Roll-off wavelength: the spectrum is constant between lam_l and lam_r."""
        return self.lam_l / self.lam_l_over_lam_r

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


class Wave(Surface):
    """z = A cos(2 pi k_x x/L_x) cos(2 pi k_y y/L_y): Westergaard with one k = 0, Johnson et al. with both."""

    kind: Literal["wave"]
    amplitude: Height = Field(description='a number, plain or as "100 nm"')
    n: Points = Field(description=POINTS)
    periods: Modes = Field((1, 0), description="two whole numbers [k_x, k_y] from 0, not both 0")

    @model_validator(mode="after")
    def _resolved(self):
        if self.periods == (0, 0):
            raise ValueError("found periods = [0, 0], allowed: two whole numbers from 0, not both 0")
        for k, n in zip(self.periods, self.n, strict=True):
            if 2 * k > n:
                raise ValueError(f"found {k} periods on {n} points, allowed: at least two points per period")
        return self


class Sphere(Surface):
    """The paraboloid z = -r^2/(2 R) about the centre of the cell."""

    kind: Literal["sphere"]
    radius: Length = Field(description=LENGTH)
    n: Points = Field(description=POINTS)


class File(Surface):
    """A measured or computed height map; the grid is the shape of the map. What the file says of sizes and units holds unless these
    keys say otherwise."""

    kind: Literal["file"]
    path: PathText = Field(description="the path of a height map (.npy, .h5, .nc, .csv, .x3p, ...)")
    dataset: PathText = Field("surface", description="the name of a data set (HDF5, NetCDF, .npz) or of a channel")
    physical_sizes: Sizes | None = Field(None, description=f'{SIZES}, plain in surface.unit or as "12.8 um"')
    unit: LengthUnit | None = Field(None, description='the unit of the heights, such as "nm"')
    boundary: Boundary | None = Field(None, description='"periodic", "free" or one of them for each axis')
    crop: Corners | None = Field(None, description="four numbers [x0, y0, x1, y1], lengths as physical_sizes")
    detrend: Literal["none", "mean", "tilt", "curvature"] = Field("none", description='"none", "mean", "tilt" or "curvature"')
    fill: Literal["none", "harmonic"] = Field("none", description='"none" or "harmonic"')
    flip: bool = Field(False, description="true or false")
    mirror: bool = Field(False, description="true or false")
    window: Literal["none", "hann", "tukey"] = Field("none", description='"none", "hann" or "tukey"')
    refine: Factor = Field(1, description=FACTOR)
    downsample: Factor = Field(1, description=FACTOR)

    @model_validator(mode="after")
    def _one_way_to_be_periodic(self):
        if self.mirror and self.window != "none":
            raise ValueError("found mirror and window, allowed: one of them")
        if any(self.free) and (self.mirror or self.window != "none" or self.refine * self.downsample > 1):
            raise ValueError("found a free boundary with mirror, window, refine or downsample, allowed: with a periodic one")
        return self

    @property
    def format(self) -> str:
        """"npy", "npz", "text", "hdf5", "netcdf" or "other", by the extension."""
        return FORMATS.get(PurePath(self.path).suffix.lower(), "other")

    @property
    def n(self) -> None:
        """Unknown before the file is read."""
        return None


FORMATS = {".npy": "npy", ".npz": "npz", ".h5": "hdf5", ".hdf5": "hdf5", ".nc": "netcdf",
           ".txt": "text", ".csv": "text", ".asc": "text", ".dat": "text"}
KINDS = {"self-affine": SelfAffine, "wave": Wave, "sphere": Sphere, "file": File}
AnySurface = Annotated[SelfAffine | Wave | Sphere | File, Field(discriminator="kind")]


def _whole(value: float, what: str) -> None:
    if not 1 <= value <= MAX_N:
        raise ValueError(f"found {what} = {value:.10g}, allowed: from 1 to {MAX_N}")
    if abs(value - round(value)) > 1e-9 * value:
        raise ValueError(f"found {what} = {value:.10g}, allowed: a whole number")
