"""The scene as one frozen object, and its conversion from and to TOML."""

import hashlib
import json
import math
import os
import re
import tomllib
from os import PathLike
from typing import Any, Self

import tomli_w
from pydantic import ValidationError, model_validator

from ..util.errors import SceneError, one_line
from ..util.quantities import NO_COMMA, format_quantity
from .explain import explain
from .history import notes_on_history, require_history
from .settings import LOADS, PRESSURES, LoadTable, Machine, Material, Output, SolverTable
from .surface import AnySurface, ArrayTable, File, SelfAffine, Wave
from .table import Table, Text, alike, has_unit, key, keys_with_unit

RESOLVED = 8  # points in a wave length; with fewer the contact is one of single points
TOUCHING = 100  # fewer contact points than this say little about a rough contact
HEIGHTS_IN_MEMORY = (
    "solver.low_memory: found true for heights that are in memory already, allowed: a scene"
    ' whose surface.kind = "self-affine" makes them row by row (hpc_gfmd.run)'
)


class Scene(Table):
    """What to solve: the surface, the material, the loads, the accuracy, and what to keep.

    Instances are validated when they are made, and frozen.
    """

    title: Text = key(
        "what the result is called", "", default_text="none", allowed="one line of text"
    )
    surface: AnySurface = key("the rigid rough surface", allowed="a table [surface]")
    material: Material = key(
        "the elastic solid that is pressed against it", Material(), allowed="a table [material]"
    )
    load: LoadTable = key("how hard", allowed="a table [load]")
    solver: SolverTable = key(
        "which algorithm, and when it may stop", SolverTable(), allowed="a table [solver]"
    )
    output: Output = key(
        "the result file, and what goes into it", Output(), allowed="a table [output]"
    )
    machine: Machine = key(
        "speed and limits, nothing of which changes the answer",
        Machine(),
        allowed="a table [machine]",
    )

    @property
    def may_break_symmetry(self) -> bool:
        """Whether a contact may vary along an axis where heights do not: with adhesion at a gap or
        an approach; under a pressure such states are no more stable.
        """
        return self.material.adhesion is not None and self.load.is_searched

    @model_validator(mode="after")
    def _rough(self) -> Self:
        """Raise ValueError if a flat surface has a load other than pressure, force or approach."""
        name, _ = self.load.prescribed
        if (
            isinstance(self.surface, Wave)
            and self.surface.amplitude == 0
            and not self.surface.radius
            and name not in ("pressure", "force", "approach")
        ):
            raise ValueError(
                f"load.{name}: found a flat surface (amplitude = 0), allowed: load.pressure"
            )
        return self

    @model_validator(mode="after")
    def _units(self) -> Self:
        """Raise ValueError if some quantities have units and others do not; a force follows lengths
        and pressures, work its range. The file of a map may have units of its own.
        """
        parts = {"surface": self.surface, "load": self.load, "material": self.material}
        lengths, pressures, forces = (
            {
                f"{name}.{key}": getattr(table, key)
                for name, table in parts.items()
                for key in keys_with_unit(type(table), dimension)
            }
            for dimension in ("length", "pressure", "force")
        )
        defaults = {
            f"{name}.{key}"
            for name, table in parts.items()
            for key in type(table).model_fields.keys() - table.model_fields_set
        }
        adhesion = self.material.adhesion
        if adhesion is not None:
            lengths["material.adhesion.range"] = adhesion.range
            pressures["material.adhesion.work"] = adhesion.work
        if self.material.E1 is not None:
            del pressures["material.E_star"]  # computed
        # a file may know units: what is built of it is compared later
        measured = isinstance(self.surface, File)
        if not measured:
            alike("lengths", lengths, defaults)
        alike(
            "pressures and forces" if self.load.force else "pressures", pressures | forces, defaults
        )
        if self.load.force and not measured:
            sizes = {"surface.physical_sizes": self.surface.physical_sizes}
            alike("lengths and forces", sizes | forces, defaults)
        if adhesion is not None:
            of_adhesion = {"range": adhesion.range, "work": adhesion.work}
            alike(
                "of work and range",
                {f"material.adhesion.{name}": x for name, x in of_adhesion.items()},
            )
        return self

    @model_validator(mode="after")
    def _pulled(self) -> Self:
        """Raise ValueError for loads that need or exclude adhesion, with which gaps and approaches
        are positive (all but the first approach on retraction and in a cycle).
        """
        adhesion, hardness = self.material.adhesion, self.material.hardness
        name, values = self.load.prescribed
        if adhesion is None:
            lowest = min(values)
            is_unloaded = lowest == 0 and self.remembers
            if name in (*PRESSURES, "approach") and lowest <= 0 and not is_unloaded:
                raise ValueError(
                    f"load.{name}: found {format_quantity(lowest)}, allowed: a number greater than"
                    " 0; with load.history or load.time also 0; with material.adhesion also 0 and"
                    " below"
                )
            if self.load.branch != "approach":
                raise ValueError(
                    f'load.branch: found "{self.load.branch}", allowed: "approach"; others with'
                    " material.adhesion"
                )
            if self.load.unique:
                raise ValueError("load.unique: found true, allowed: with material.adhesion")
            return self
        if hardness is not None:
            raise ValueError(
                f"material.adhesion: found beside material.hardness = {format_quantity(hardness)},"
                " allowed: one of them"
            )
        if name == "a_r":
            alternatives = ", ".join(load for load in LOADS if load != "a_r")
            raise ValueError(
                "load.a_r: found with material.adhesion, where areas jump and several loads may"
                f" give the same, allowed: {alternatives}"
            )
        positive = values[:1] if self.branch != "approach" and name == "approach" else values
        lowest = min(positive)
        if name not in PRESSURES and lowest <= 0:
            raise ValueError(
                f"load.{name}: found {format_quantity(lowest)} with material.adhesion, allowed:"
                " a number greater than 0; an approach on retraction or with load.history, but for"
                " the first, also 0 and below"
            )
        return self

    @model_validator(mode="after")
    def _memory(self) -> Self:
        """Raise ValueError for a history that the scene cannot have, see history.py."""
        require_history(self.load, self.material, self.output)
        if self.solver.low_memory and self.remembers:
            raise ValueError("solver.low_memory: found true with a history, allowed: false")
        return self

    @property
    def remembers(self) -> bool:
        """Whether loads change the wall for later ones: dents stay, or the solid relaxes."""
        dents_stay = self.load.history and self.material.hardness is not None
        return dents_stay or self.material.relaxation is not None

    @property
    def branch(self) -> str:
        """The branch of adhesion: "approach", "retraction", or with load.history "cycle"."""
        is_cycle = self.load.history and self.material.adhesion is not None
        return "cycle" if is_cycle else self.load.branch

    @model_validator(mode="after")
    def _load_fits(self) -> Self:
        """Raise ValueError for a force or approach that the boundary, if given here, excludes."""
        if self.load.force and not any(self.surface.free):
            raise ValueError(
                "load.force: found no free boundary, allowed: with a free boundary (without:"
                " load.pressure)"
            )
        if self.load.approach and not (all(self.surface.free) or self.material.rigid_base):
            raise ValueError(
                "load.approach: found a half-space that gives way without end, allowed: with free"
                " boundaries along both axes, or material.thickness on a rigid base"
            )
        return self

    @property
    def length_unit(self) -> str:
        """Unit of lengths in the scene, "m" or "" without one; a map's file may have its own."""
        return "m" if has_unit(self.surface.physical_sizes) else ""

    @property
    def pressure_unit(self) -> str:
        """Unit of pressures in the scene: "Pa" if they have units, else ""."""
        return "Pa" if has_unit(self.material.E1 or self.material.E_star) else ""

    @property
    def time_unit(self) -> str:
        """Unit of times of a history: "s" if they have units, else ""."""
        elements = self.material.relaxation or ()
        return "s" if has_unit([tau for _, tau in elements]) else ""

    @classmethod
    def from_dict(
        cls, data: dict[str, Any], origin: str = "scene", folder: str | PathLike | None = None
    ) -> "Scene":
        """Return a validated scene from tables as read from TOML, or raise SceneError, which begins
        with `origin`.

        folder: that to which relative paths of height maps refer; they become absolute. Default:
        they stay.
        """
        try:
            return cls.model_validate(data, context=folder and os.path.abspath(folder))
        except ValidationError as error:
            raise SceneError(f"{origin}: {explain(error, cls, data)}") from None

    @classmethod
    def from_toml(cls, text: str, origin: str = "scene") -> "Scene":
        """Return a validated scene from TOML text; errors begin with `origin`."""
        return cls.from_dict(parse_toml(text, origin), origin)

    def to_toml(self) -> str:
        """Return TOML text of an equal scene, with all defaults but None and nothing derived."""
        return tomli_w.dumps(self.model_dump(exclude_none=True))

    def identity(self) -> str:
        """Return the SHA-256 (hex) of all that may change the result: not [machine], title, path,
        lossless compression and orders of names. A height map enters by its path.
        """
        data = self.model_dump(
            mode="json", exclude={"machine": True, "title": True, "output": {"path", "compression"}}
        )
        for names in ("fields", "observables", "distributions"):
            data["output"][names] = data["output"][names] and sorted(data["output"][names])
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()

    def warnings(self) -> list[str]:
        """Return notes on settings that are valid but perhaps not intended, one line each."""
        surface = self.surface
        notes = notes_on_history(self.load, self.material)
        if isinstance(surface, Wave):
            notes += [
                f"surface: {n} points along {axis} for {k} periods, fewer than {RESOLVED} points a"
                " period"
                for axis, n, k in zip("xy", surface.n, surface.periods)
                if n < RESOLVED * k
            ]
        # more touches then than at time 0, or without adhesion
        more_touches = self.material.adhesion is not None or self.material.relaxation is not None
        if not isinstance(surface, SelfAffine) or surface.radius:
            return notes
        if surface.eps_f > 1 / 8:
            ratio = surface.lam_l_over_lam_s
            notes.append(f"surface: lam_l_over_lam_s = {ratio:g} is hardly self-affine")
        if surface.aspect < surface.eps_t:
            notes.append("surface: L_y is shorter than lam_l, the roughness is not isotropic")
        n_x, n_y = surface.n
        _, values = self.load.prescribed
        for load, area in zip(values, self._contact_areas(surface)):
            if area * n_x * n_y < TOUCHING and not more_touches:
                notes.append(
                    f"load: at {load:g} fewer than {TOUCHING} of the {n_x} x {n_y} points touch"
                )
        return notes

    def _contact_areas(self, surface: SelfAffine) -> list[float]:
        """Return the contact area of each load, load.a_r or about 2 p*; [] if p* is unknown."""
        if self.load.a_r:
            return list(self.load.a_r)
        unit = 1.0 if self.load.p_star else (surface.g_rms or 0.0) * self.material.E_star
        if not unit:
            return []
        area = math.prod(surface.physical_sizes)
        return [2 * p / unit for p in self.load.p0(unit, 1.0, area)]


class ArrayScene(Scene):
    """A scene whose heights are an array in memory: its surface has only sizes and boundary."""

    surface: ArrayTable = key(  # type: ignore[assignment]
        "the sizes of the heights", ArrayTable(), allowed="a table [surface]"
    )

    @model_validator(mode="after")
    def _known_by_points(self) -> Self:
        """Raise ValueError for solver.low_memory, which generates heights from a spectrum."""
        if self.solver.low_memory:
            raise ValueError(HEIGHTS_IN_MEMORY)
        return self

    @model_validator(mode="after")
    def _sized(self) -> Self:
        """Raise ValueError for a modulus with a unit beside heights whose sizes are not given."""
        if self.pressure_unit and "physical_sizes" not in self.surface.model_fields_set:
            name = "E_star" if self.material.E1 is None else "E1"
            modulus = format_quantity(getattr(self.material, name))
            raise ValueError(
                f"surface.physical_sizes: not given, hence 1 beside material.{name} = {modulus!r},"
                " allowed: sizes of the array, plain in the unit of its heights or with units"
            )
        return self


def parse_toml(text: str, origin: str) -> dict[str, Any]:
    """Return the tables of a TOML text; errors begin with `origin` and name the line."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise SceneError(
            f"{origin}: found values nested too deeply, allowed: a scene in TOML"
        ) from None
    except ValueError as error:
        comma = re.search(r"=\s*[-+]?\d+,\d", text)
        why = f" ({NO_COMMA}: {one_line(comma[0][1:].strip())})" if comma else ""
        raise SceneError(f"{origin}: not valid TOML: {one_line(str(error))}{why}") from None
