"""Keys of a scene for random roughness: its spectrum, and how it is stretched along a direction."""

from itertools import pairwise
from math import cos, radians, sin
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from .table import (
    LIST,
    MAX_INT,
    Length,
    LengthUnit,
    MapPath,
    Pair,
    Points,
    Positive,
    Table,
    key,
    one_of,
)

ROUNDING = 1e-12  # relative, by which a wave may lie beyond the end of a spectrum
Numbers = Annotated[tuple[Positive, ...], Field(min_length=2), LIST]
Exponent = Annotated[float, Field(ge=-1, le=10)]
LISTED = "a list of at least two positive numbers"


class Anisotropy(Table):
    """How the waves of an isotropic surface are stretched along a direction, with h_rms kept."""

    peklenik: Annotated[float, Field(ge=1e-3, le=1e3)] = key(
        "correlation length along angle over that across: the spectrum is constant on ellipses",
        1.0,
        example=5.0,
    )
    angle: Annotated[float, Field(ge=-180, le=180)] = key(
        "direction of the lay, from x towards y", 0.0, unit="degrees", example=30.0
    )

    @property
    def stretch(self) -> tuple[float, float, float]:
        """Factors of q_x^2, q_x q_y, q_y^2 in the square of the wave number of C."""
        if self.peklenik == 1:
            return 1.0, 0.0, 1.0
        c = cos(radians(self.angle))
        s = sin(radians(self.angle))
        along = self.peklenik
        across = 1 / self.peklenik
        return (
            along * c**2 + across * s**2,
            2 * (along - across) * c * s,
            along * s**2 + across * c**2,
        )

    def require_resolved(self, k: float, n: tuple[int, int], aspect: float, q: str = "") -> None:
        """Raise ValueError if the grid misses waves; k: of the shortest, in periods along x."""
        xx, _, yy = self.stretch
        for axis, periods, points in (("x", k * yy**0.5, n[0]), ("y", k * aspect * xx**0.5, n[1])):
            if points > 1 and int(periods * (1 + ROUNDING)) > points // 2:
                raise ValueError(
                    f"found {q}waves with {periods:.6g} periods along {axis} on {points} points,"
                    f" allowed: at most {points // 2}, two points a period"
                )


class Scaled(Table):
    """Heights that are scaled to an rms height or slope."""

    h_rms: Length | None = key(
        "rms height to which the heights are scaled",
        None,
        unit="length",
        default_text="as they are",
        example=0.01,
    )
    g_rms: Positive | None = key(
        "rms slope to which they are scaled, instead of h_rms",
        None,
        default_text="as they are",
        example=1.0,
    )

    @property
    def is_scaled(self) -> bool:
        """Whether one of both is given."""
        return self.h_rms is not None or self.g_rms is not None

    @model_validator(mode="after")
    def _one_scale(self) -> Self:
        if self.h_rms is not None and self.g_rms is not None:
            raise ValueError("found h_rms and g_rms, allowed: one of them")
        return self


class SpectrumKeys(Anisotropy, Scaled):
    """Keys of kind = "spectrum"."""

    path: MapPath | None = key(
        "of a table: columns q and C, units in the head; or arrays q_x, q_y, C",
        None,
        allowed="the path of a text, such as a .csv, or of a .npz or HDF5 file",
        default_text="none",
        example="spectrum.csv",
    )
    q: Numbers | None = key(
        "instead of path: wave numbers 2 pi/lambda of the table",
        None,
        allowed=LISTED,
        default_text="none",
        example=[1.0, 10.0, 100.0],
    )
    C: Numbers | None = key(
        "power spectrum at these q", None, allowed=LISTED, example=[1e-3, 1e-6, 1e-10]
    )
    unit: LengthUnit | None = key(
        "of length, in which q and C are",
        None,
        example="um",
        default_text="what the head of the table says",
        allowed='a unit of length, such as "um"',
    )
    dimension: Literal[1, 2] | None = key(
        "of C: 2 for areas (isotropic), 1 for profiles",
        None,
        allowed="1 or 2",
        example=2,
        default_text="what the head of the table says",
    )
    wavelengths: Annotated[tuple[Length, ...], Field(min_length=2), LIST] | None = key(
        "instead of a table: between which C is a power law, falling",
        None,
        unit="length",
        allowed='a list of at least two lengths, plain or as "20 um"',
        example=["100 um", "20 um", "0.1 um"],
    )
    hurst: Annotated[tuple[Exponent, ...], LIST] | None = key(
        "Hurst exponent H between each two wavelengths: C falls as q^(-2 - 2 H); -1: constant",
        None,
        allowed="a list of numbers from -1 to 10, one less than wavelengths",
        example=[-1.0, 0.8],
    )
    longest: Length | None = key(
        "waves that are longer are left out", None, unit="length", example="20 um"
    )
    shortest: Length | None = key(
        "waves that are shorter are left out", None, unit="length", example="0.1 um"
    )
    n: Pair[Points] = key("grid points [n_x, n_y]", example=[512, 512])
    seed: Annotated[int, Field(ge=0, le=MAX_INT)] = key(
        "of the random numbers; gives the same surface on any grid", example=1
    )
    random: Literal["amplitudes", "phases"] = key(
        'what is random: "amplitudes" and phases, so that the power scatters, or "phases"',
        "amplitudes",
    )
    skewness: Annotated[float, Field(ge=-20, le=20)] | None = key(
        "of the heights, with the spectrum kept", None, default_text="0", example=-1.0
    )
    kurtosis: Annotated[float, Field(gt=1, le=1000)] | None = key(
        "of the heights, 3: Gaussian", None, default_text="3", example=5.0
    )
    heights: MapPath | None = key(
        "instead of both: numbers that are distributed as the heights shall be",
        None,
        allowed="the path of a .npy or a text",
        default_text="none",
        example="heights.npy",
    )

    @property
    def has_distribution(self) -> bool:
        """Whether the distribution of heights is given; otherwise it is about Gaussian."""
        return (self.skewness, self.kurtosis, self.heights) != (None, None, None)

    @model_validator(mode="after")
    def _one_distribution(self) -> Self:
        """Raise ValueError for moments that no distribution has, and beside a distribution."""
        if self.heights is not None and (self.skewness, self.kurtosis) != (None, None):
            raise ValueError("found heights beside skewness or kurtosis, allowed: one of them")
        skewness = self.skewness or 0.0
        kurtosis = 3.0 if self.kurtosis is None else self.kurtosis
        if kurtosis <= 1 + skewness**2:
            raise ValueError(
                f"found skewness = {skewness:g} and kurtosis = {kurtosis:g}, allowed: kurtosis"
                " above 1 + skewness^2"
            )
        return self

    @model_validator(mode="after")
    def _one_spectrum(self) -> Self:
        """Raise ValueError unless there is one spectrum, with the keys that it needs."""
        one_of(self, "path", "q", "wavelengths")
        if (self.q is None) != (self.C is None):
            raise ValueError("found one of q and C, allowed: both or none")
        if (self.wavelengths is None) != (self.hurst is None):
            raise ValueError("found one of wavelengths and hurst, allowed: both or none")
        if self.wavelengths is not None and self.hurst is not None:
            if any(longer <= shorter for longer, shorter in pairwise(self.wavelengths)):
                raise ValueError(
                    "found wavelengths that do not fall, allowed: from the longest to the shortest"
                )
            if len(self.hurst) != len(self.wavelengths) - 1:
                raise ValueError(
                    f"found {len(self.hurst)} numbers hurst for {len(self.wavelengths)}"
                    " wavelengths, allowed: one less"
                )
            if not self.is_scaled:
                raise ValueError("found wavelengths alone, allowed: with h_rms or g_rms")
            if self.dimension or self.unit:
                name = "dimension" if self.dimension else "unit"
                raise ValueError(f"found {name} beside wavelengths, allowed: with a table")
        return self

    @model_validator(mode="after")
    def _array_fits(self) -> Self:
        """Raise ValueError for arrays that are no table, or of which unit or dimension is open."""
        if self.q is None or self.C is None:
            return self
        if len(self.q) != len(self.C):
            raise ValueError(f"found {len(self.q)} q and {len(self.C)} C, allowed: as many of each")
        if any(after <= before for before, after in pairwise(self.q)):
            raise ValueError("found q that do not rise, allowed: rising ones")
        if self.dimension is None:
            raise ValueError("dimension: not given, allowed: 2 (areas) or 1 (profiles)")
        return self


class FourierKeys(Scaled):
    """Keys of kind = "fourier"."""

    path: MapPath = key(
        "of the coefficients; a relative one counts from the folder of the scene",
        allowed="the path of a text, .npy, .npz or HDF5 file",
        example="coefficients.h5",
    )
    unit: LengthUnit | None = key(
        "of the coefficients", None, example="um", allowed='a unit of length, such as "um"'
    )
    n: Pair[Points] = key("grid points [n_x, n_y]", example=[512, 512])
