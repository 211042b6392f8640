"""The tables beside [surface]: [material], [load], [solver], [output] and [machine]."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_serializer, model_validator

from .table import (
    FRACTION,
    LENGTH,
    MAX_INT,
    POSITIVE,
    Fraction,
    Length,
    Loads,
    Path,
    Positive,
    Pressure,
    Pressures,
    Table,
    Text,
    Whole,
    names,
    not_both,
)

MODULUS = f'{POSITIVE}, plain or as "50 GPa"'
SOLIDS = ("E1", "nu1", "E2", "nu2")
PoissonRatio = Annotated[float, Field(gt=-1, le=0.5)]
Parameter = Annotated[int, Field(ge=-MAX_INT, le=MAX_INT)] | float
POISSON = "a number above -1 and up to 0.5"
WHOLE = f"a whole number from 1 to {MAX_INT}"


def effective_modulus(E1: float, nu1: float, E2: float = float("inf"), nu2: float = 0.0) -> float:
    """E* of two linear elastic solids, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 (eq. effMod); the second one is rigid by default."""
    return 1 / ((1 - nu1**2) / E1 + (1 - nu2**2) / E2)


def _E_star(given: dict) -> float:
    solids = {key: given[key] for key in SOLIDS if given.get(key) is not None}
    return effective_modulus(**solids) if tuple(solids) in (SOLIDS[:2], SOLIDS) else 1.0


class Material(Table):
    """The effective modulus E_star (default 1), one solid that presses against a rigid counterface, or both; `E_star` has the value in
    any case. With a thickness the solid is a layer on a rigid base, and its nu1 counts beside E1 or E_star."""

    E1: Pressure | None = Field(None, description=MODULUS)
    nu1: PoissonRatio | None = Field(None, description=POISSON)
    E2: Pressure | None = Field(None, description=MODULUS)
    nu2: PoissonRatio | None = Field(None, description=POISSON)
    E_star: Pressure = Field(default_factory=_E_star, description=MODULUS)
    thickness: Length | None = Field(None, description=LENGTH)
    base: Literal["bonded", "frictionless"] = Field("bonded", description='"bonded" or "frictionless"')

    @model_validator(mode="after")
    def _one_way(self):
        # E_star is in the set only if it was given, not if it was computed
        given = "E_star" in self.model_fields_set
        found = ["E_star"] * given + [key for key in SOLIDS if getattr(self, key) is not None]
        ways = {"E1, nu1": "a rigid counterface"}
        if self.thickness is None:
            ways |= {"": "", "E_star": "", ", ".join(SOLIDS): ""}
        else:
            ways |= {"nu1": "E_star = 1", "E_star, nu1": ""}
        if ", ".join(found) not in ways:
            allowed = "; ".join(f"{way} ({why})" if why else way for way, why in ways.items() if way)
            with_it = "" if self.thickness is None else "thickness with "
            raise ValueError(f"found {with_it}{', '.join(found) or 'nothing else'}, allowed: {with_it}{allowed}")
        return self

    @model_validator(mode="after")
    def _layer(self):
        if self.thickness is None and "base" in self.model_fields_set:
            raise ValueError(f'found base = "{self.base}" without thickness, allowed: both, or none')
        if self.thickness is not None and self.base == "bonded" and self.nu1 == 0.5:
            raise ValueError('found nu1 = 0.5 with thickness and base = "bonded", allowed: nu1 below 0.5, or base = "frictionless" '
                             "(an incompressible bonded layer does not give way to a uniform pressure)")
        return self

    @model_serializer(mode="wrap")
    def _as_given(self, dump) -> dict[str, Any]:
        table = dump(self)
        if self.E1 is not None:
            table.pop("E_star", None)
        if self.thickness is None:
            table.pop("base", None)
        return table


class Load(Table):
    """The pressures of a sweep, in order: p_star = p0/(E* g_rms), or absolute in the unit of E_star."""

    p_star: Loads | None = Field(None, description="a positive number or a list of them")
    pressure: Pressures | None = Field(None, description='a positive number, plain or as "20 MPa", or a list of them')

    @model_validator(mode="after")
    def _one(self):
        not_both(self, "p_star", "pressure")
        if self.p_star is None and self.pressure is None:
            raise ValueError("found nothing, allowed: one of p_star, pressure")
        return self

    def p0(self, E_star: float, g_rms: float) -> tuple[float, ...]:
        """The mean pressures, in the unit of E_star, on a surface of realised g_rms."""
        return tuple(map(float, self.pressure)) if self.pressure else tuple(p_star * E_star * g_rms for p_star in self.p_star)


class Solver(Table):
    """Which algorithm, and when it may stop. `accuracy` is None where a residual was given."""

    name: Text = Field("auto", description='"auto" or the name of a solver')
    residual: Fraction | None = Field(None, description=FRACTION)
    accuracy: Fraction | None = Field(
        default_factory=lambda given: 1e-3 if given.get("residual") is None else None, description=FRACTION)
    precision: Literal["auto", "single", "double"] = Field("auto", description='"auto", "single" or "double"')
    max_iterations: Whole = Field(100_000, description=WHOLE)
    nested: Literal["auto"] | bool = Field("auto", description='"auto", true or false')
    low_memory: bool = Field(False, description="true or false")
    options: dict[str, Parameter] = Field({}, description="a table of numbers, the solver's own parameters")

    @model_validator(mode="after")
    def _one(self):
        not_both(self, "accuracy", "residual")
        if self.accuracy is None and self.residual is None:
            raise ValueError("found neither accuracy nor residual, allowed: one of accuracy, residual")
        return self


class Output(Table):
    """The result file and what goes into it. `observables` is None for all the cheap ones."""

    path: Annotated[Path, Field(pattern=r"[^/]\.([hH]5|[hH][dD][fF]5)$")] = Field(
        "contact.h5", description="a path that ends in .h5 or .hdf5")
    fields: names(Literal["pressure", "gap", "displacement", "heights"]) = Field(
        (), description='a list out of "pressure", "gap", "displacement", "heights", each once')
    observables: names(Path) | None = Field(None, description="a list of names, each once")
    distributions: names(Path) = Field((), description="a list of names, each once")
    dtype: Literal["single", "double"] | None = Field(None, description='"single" or "double"')
    compression: bool = Field(False, description="true or false")


class Machine(Table):
    """Speed and limits only: nothing here changes the answer."""

    threads: Annotated[int, Field(ge=1, le=65536)] | Literal["auto"] = Field(
        1, description='a whole number from 1, or "auto"')
    wall_seconds: Positive | None = Field(None, description=POSITIVE)
    checkpoint_seconds: Positive = Field(600.0, description=POSITIVE)
    memory_gib: Positive | None = Field(None, description=POSITIVE)
