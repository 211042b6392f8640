"""The tables beside [surface]: [material], [load], [solver], [output] and [machine]."""

from math import inf
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from .table import (
    DISTINCT,
    LIST,
    MAX_INT,
    Coordinate,
    Fraction,
    Length,
    Loads,
    Moment,
    NotNegative,
    Path,
    Positive,
    Pressure,
    Share,
    Signed,
    SignedForce,
    SignedLength,
    SignedPressure,
    Table,
    Text,
    Time,
    Whole,
    Work,
    key,
    one_of,
)

SOLIDS = ("E1", "nu1", "E2", "nu2")
PoissonRatio = Annotated[float, Field(gt=-1, le=0.5)]
Parameter = Annotated[int, Field(ge=-MAX_INT, le=MAX_INT)] | float
Elements = Annotated[tuple[Annotated[tuple[Share, Time], LIST], ...], Field(min_length=1), LIST]
Names = Annotated[tuple[Path, ...], LIST, DISTINCT]
Fields = Annotated[
    tuple[Literal["pressure", "gap", "displacement", "plastic", "dent", "heights"], ...],
    LIST,
    DISTINCT,
]
NAMES = "a list of names, each once"
PUSH = "greater than 0, with material.adhesion also 0 and below"


def _effective_modulus(solids: dict) -> float:
    """Return E* from 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 (eq. effMod); 1 by default."""
    E1, nu1, E2, nu2 = (solids.get(key) for key in SOLIDS)
    if E1 is None or nu1 is None:
        return 1.0
    return 1 / ((1 - nu1**2) / E1 + (1 - (nu2 or 0.0) ** 2) / (E2 or inf))


class Adhesion(Table):
    """Attraction of the two surfaces across the gap.

    The energy per area is -work where they touch, and rises to 0 over the range.
    """

    work: Work = key(
        "work of adhesion per area, from contact to infinity", unit="work", example="50 mJ/m2"
    )
    range: Length = key("length over which the attraction falls", unit="length", example="2 nm")
    law: Text = key(
        "how it falls with the gap",
        "exponential",
        allowed='"exponential" or the name of another law',
    )


class Material(Table):
    """The effective modulus E_star (default 1), or the elastic constants of one or both solids.

    Without E2 the counterface is rigid. With a thickness the solid is a layer on a rigid base or on
    an elastic half-space, and nu1 is needed beside E1 or E_star.
    """

    E1: Pressure | None = key(
        "Young's modulus of the elastic solid (alone with nu1: against a rigid one)",
        None,
        unit="pressure",
        example="50 GPa",
    )
    nu1: PoissonRatio | None = key("its Poisson ratio", None, example=0.3)
    E2: Pressure | None = key(
        "Young's modulus of the other solid, whose roughness counts to the surface's",
        None,
        unit="pressure",
        example="2 GPa",
    )
    nu2: PoissonRatio | None = key("its Poisson ratio", None, example=0.4)
    E_star: Pressure = key(
        "effective modulus, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2",
        default_factory=_effective_modulus,
        unit="pressure",
        example=1.0,
        default_text="1, or from E1, nu1, E2, nu2",
    )
    thickness: Length | None = key(
        "makes the elastic solid a layer of this thickness on a base (needs nu1)",
        None,
        unit="length",
        example=0.05,
        default_text="a half-space",
    )
    base: Literal["bonded", "frictionless", "elastic"] = key(
        "how the layer lies on its base: on a rigid one, or bonded to an elastic half-space",
        "bonded",
    )
    base_E: Pressure | None = key(
        "Young's modulus of the elastic base", None, unit="pressure", example="200 GPa"
    )
    base_nu: PoissonRatio | None = key("its Poisson ratio", None, example=0.3)

    hardness: Pressure | None = key(
        "the largest pressure, where the solid gets a dent (elastic - perfectly plastic)",
        None,
        unit="pressure",
        example="6 GPa",
        default_text="none, elastic",
    )

    relaxation: Elements | None = key(
        "shares of the modulus at time 0 that relax, and their times (Prony series)",
        None,
        unit="time",
        allowed="a list of [share, time], shares above 0 with a sum below 1, times above 0",
        example=[[0.6, "1 s"], [0.3, "10 s"]],
        default_text="none, elastic",
    )

    adhesion: Adhesion | None = key(
        "attraction of the two surfaces across the gap",
        None,
        allowed="a table {work, range, law}",
        example={"work": "50 mJ/m2", "range": "2 nm", "law": "exponential"},
        default_text="none",
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        """Raise ValueError unless moduli are none, E_star, (E1, nu1) or (E1, nu1, E2, nu2); with a
        thickness nu1, (E_star, nu1) or (E1, nu1).
        """
        # E_star is in the set only if it was given, not if it was computed
        keys = [key for key in SOLIDS if getattr(self, key) is not None]
        if "E_star" in self.model_fields_set:
            keys.insert(0, "E_star")
        combination = ", ".join(keys)
        layer = "" if self.thickness is None else "thickness with "
        if combination == "nu1" and not layer:
            raise ValueError("found nu1 (nu) alone, allowed: with E1, or with thickness (a layer)")
        ways = ["E1, nu1 (a rigid counterface)"]
        ways += ["nu1 (E_star = 1)", "E_star, nu1"] if layer else ["E_star", "E1, nu1, E2, nu2"]
        allowed = [way.partition(" (")[0] for way in ways]
        if (combination or layer) and combination not in allowed:
            raise ValueError(
                f"found {layer}{combination or 'nothing else'}, allowed: {layer}{'; '.join(ways)}"
            )
        return self

    @property
    def rigid_base(self) -> bool:
        """Whether the solid is a layer on a rigid base."""
        return self.thickness is not None and self.base != "elastic"

    @model_validator(mode="after")
    def _layer(self) -> Self:
        """Raise ValueError if the keys of the layer and its base do not fit together."""
        if self.thickness is None and "base" in self.model_fields_set:
            raise ValueError(
                f'found base = "{self.base}" without thickness, allowed: both, or none'
            )
        keys = [key for key in ("base_E", "base_nu") if getattr(self, key) is not None]
        if len(keys) != (2 if self.base == "elastic" else 0):
            raise ValueError(
                f'found base = "{self.base}" with {" and ".join(keys) or "no base_E"}, allowed:'
                ' base = "elastic" with base_E and base_nu, or none of them'
            )
        if self.thickness is not None and self.base == "bonded" and self.nu1 == 0.5:
            raise ValueError(
                'found nu1 = 0.5 with thickness and base = "bonded", allowed: nu1 below 0.5, or'
                ' base = "frictionless" (an incompressible bonded layer does not give way to a'
                " uniform pressure)"
            )
        return self

    @model_serializer(mode="wrap")
    def _as_given(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Return the table for TOML, without what would be refused when it is read again."""
        table = dump(self)
        if self.E1 is not None:
            table.pop("E_star", None)
        if self.thickness is None:
            table.pop("base", None)
        return table


class LoadTable(Table):
    """The loads of a sweep, in order: mean pressures, or another quantity.

    For another quantity, such as a contact area, the mean pressure is found by a search.
    """

    p_star: Loads[Signed] | None = key(
        f"mean pressures p0/(E* g_rms), solved in this order; {PUSH}", None, example=[0.01, 0.1]
    )
    pressure: Loads[SignedPressure] | None = key(
        f"mean pressures instead of p_star; {PUSH}",
        None,
        unit="pressure",
        example=["2 MPa", "20 MPa"],
    )
    gap_mean: Loads[Coordinate] | None = key(
        "mean gaps, whose pressures are found; 0: full contact",
        None,
        unit="length",
        example="50 nm",
    )
    gap_over_h_rms: Loads[NotNegative] | None = key(
        "the same, over the rms height", None, example=0.5
    )
    a_r: Loads[Share] | None = key(
        "relative contact areas, whose pressures are found; met to the accuracy or to one point",
        None,
        example=[0.01, 0.1],
    )
    force: Loads[SignedForce] | None = key(
        f"forces on a surface with free edges; {PUSH}", None, unit="force", example="5 mN"
    )
    approach: Loads[SignedLength] | None = key(
        "how far the bodies come together after they touch (free boundaries along both axes, or a"
        " layer)",
        None,
        unit="length",
        example="10 nm",
    )
    branch: Literal["approach", "retraction"] = key(
        "with material.adhesion: reach a load from less contact, as on approach, or from more",
        "approach",
    )
    unique: bool = key(
        "with material.adhesion: solve each load on the other branch, too, and say whether both"
        " agree",
        False,
    )
    time: Loads[Moment] | None = key(
        "with material.relaxation: when the loads are reached, linearly; twice the same: a jump",
        None,
        unit="time",
        example=["0 s", "1 s", "10 s"],
    )
    history: bool = key(
        "loads follow from each other: with a hardness dents stay, with adhesion the direction"
        " tells the branch",
        False,
    )

    @model_validator(mode="after")
    def _one(self) -> Self:
        one_of(self, *LOADS)
        return self

    @property
    def prescribed(self) -> tuple[str, tuple[float, ...]]:
        """(name of the prescribed quantity, its values); a single value is that of all times."""
        name = next(name for name in LOADS if getattr(self, name) is not None)
        values = getattr(self, name)
        return name, values * len(self.time or [0]) if len(values) == 1 else values

    @property
    def is_searched(self) -> bool:
        """Whether the mean pressures follow from another quantity by a search."""
        return self.prescribed[0] not in PRESSURES

    def unit(self, E_star: float, g_rms: float, area: float = 1.0) -> float:
        """Return the mean pressure of a pressure, force or p* of 1; for the arguments see `p0`."""
        return {"p_star": E_star * g_rms, "force": 1 / area}.get(self.prescribed[0], 1.0)

    def p0(self, E_star: float, g_rms: float, area: float = 1.0) -> tuple[float, ...]:
        """Return the mean pressures over E_star, () if searched for; g_rms: on the grid, for
        p_star; area: for forces.
        """
        _, values = self.prescribed
        unit = self.unit(E_star, g_rms, area)
        return () if self.is_searched else tuple(float(value) * unit for value in values)


PRESSURES = ("p_star", "pressure", "force")
HOW = ("branch", "unique", "time", "history")  # keys of [load] beside the loads
# one of them is given
LOADS = tuple(name for name in LoadTable.model_fields if name not in HOW)


class SolverTable(Table):
    """Which algorithm, and when it may stop: at an accuracy or at a residual."""

    name: Text = key(
        "the algorithm; gfmd is that of the paper", "auto", allowed='"auto" or the name of a solver'
    )
    residual: Fraction | None = key(
        "instead of accuracy: rms pressure at points where the gap is open, over the mean pressure",
        None,
        example=1e-8,
    )
    accuracy: Fraction | None = key(
        "wanted relative accuracy of contact area, mean gap and pressure field",
        default_factory=lambda given: 1e-3 if given.get("residual") is None else None,
        example=1e-3,
        default_text="0.001, unless residual is given",
    )
    precision: Literal["auto", "single", "double"] = key(
        "of the floating-point numbers; auto: double where a load needs it", "auto"
    )
    max_iterations: Whole = key("of one load, after which it ends as not converged", 100_000)
    nested: Literal["auto"] | bool = key("begin on coarser grids", "auto")
    low_memory: bool = key(
        "make the heights anew where they are needed (surfaces known by their waves): half the"
        " memory, longer",
        False,
    )
    options: dict[str, Parameter] = key(
        "the solver's own parameters", {}, allowed="a table of numbers"
    )

    @model_validator(mode="after")
    def _one(self) -> Self:
        one_of(self, "accuracy", "residual")
        return self

    @property
    def tolerance(self) -> float:
        """The accuracy, or the residual if that is given instead."""
        return self.accuracy or self.residual or 0.0


class Output(Table):
    """The result file and its content: numbers, maps, distributions."""

    path: Annotated[Path, Field(pattern=r"[^/]\.([hH]5|[hH][dD][fF]5)$")] = key(
        "the result file, in a folder that exists",
        "contact.h5",
        allowed="a path that ends in .h5 or .hdf5",
    )
    fields: Fields = key(
        "maps that are kept; pictures of the contact need pressure or gap",
        (),
        example=["pressure", "gap"],
        default_text="none",
        allowed='a list out of "pressure", "gap", "displacement", "plastic", "dent", "heights",'
        " each once",
    )
    observables: Names | None = key(
        "numbers of each load, beside the cheap ones that every load has; see hpc-gfmd help"
        " observables",
        None,
        example=["stiffness", "patches"],
        allowed=NAMES,
    )
    distributions: Names = key(
        "histograms and spectra of each load",
        (),
        example=["pressure", "gap"],
        default_text="none",
        allowed=NAMES,
    )
    dtype: Literal["single", "double"] | None = key(
        "precision of the stored fields", None, example="single", default_text="as solved"
    )
    compression: bool = key("compress the stored fields without loss", False)


class Machine(Table):
    """Speed and limits only: nothing here changes the results."""

    threads: Annotated[int, Field(ge=1, le=65536)] | Literal["auto"] = key(
        "threads of each rank; auto: all cores of one process where they pay, one of several ranks",
        "auto",
    )
    wall_seconds: Positive | None = key(
        "stop after this time, so that the run can go on",
        None,
        unit="s",
        example=3600.0,
        default_text="never",
    )
    memory_gib: Positive | None = key(
        "memory of each machine that may be used",
        None,
        unit="GiB",
        example=8.0,
        default_text="what is free",
    )
