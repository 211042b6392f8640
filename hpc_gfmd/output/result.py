"""Content of a result file, or of a solution in memory."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..scene import ArrayScene, Scene
from ..scene.model import parse_toml
from ..util.errors import SceneError
from ..util.quantities import format_quantity
from .numbers import scalar_names

FORMAT_VERSION = 3
# (table, key) that scenes in older files may have, and that changed no result
WITHDRAWN = (("machine", "checkpoint_seconds"),)


@dataclass(frozen=True)
class Result:
    """Content of a result file, or of a solution in memory."""

    path: Path | None  # the file; None in memory
    surface: dict  # attributes of the surface
    steps: list[dict]  # attributes of each load step
    # number of each load step in the scene, from 0; loads not finished are missing
    indices: list[int]
    status: str  # of the whole run; "running" or "interrupted" if it is not finished
    head: dict  # root attributes
    # of each load step by name: Stored in a file, Slab in memory
    fields: list[dict[str, Any]] = field(repr=False)
    folder: Path | None = None  # of partial results of an unfinished run; None if it is finished
    notes: tuple[str, ...] = ()  # what may be wrong with the surface, and what the result lacks
    # of the format; a pickle of another version is refused
    version: int = field(default=FORMAT_VERSION, repr=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore from a pickle. Raises SceneError if another version has written it."""
        if state.get("version") != FORMAT_VERSION:
            raise SceneError("a pickle of another version of hpc_gfmd, allowed: of this one")
        vars(self).update(state)

    @property
    def scene_toml(self) -> str:
        """The scene that was solved, as TOML text; "" if the result has none."""
        return str(self.head.get("scene", ""))

    @property
    def scene(self) -> Scene:
        """The scene that was solved; an ArrayScene if the heights were an array."""
        table = parse_toml(self.scene_toml, str(self.path))
        for name, key in WITHDRAWN:
            if isinstance(table.get(name), dict):
                table[name].pop(key, None)
        surface = table.get("surface")
        if isinstance(surface, dict) and surface.pop("mirror", False):  # as 1.0 wrote it
            surface["boundary"] = "mirror"
        return (Scene if "kind" in table.get("surface", {}) else ArrayScene).from_dict(
            table, str(self.path)
        )

    @property
    def readable_scene(self) -> Scene | None:
        """The `scene`; None if there is none, or if this version rejects it."""
        try:
            return self.scene
        except SceneError:
            return None

    @property
    def remarks(self) -> list[str]:
        """Lines to print beside any output: the notes, and a warning if the run is not finished."""
        unfinished = f"! the run is {self.status}: only its finished load steps are there"
        return [f"note: {note}" for note in self.notes] + [unfinished] * (self.folder is not None)

    @property
    def numbered(self) -> dict[int, dict]:
        """{number of the load step: its attributes}."""
        return dict(zip(self.indices, self.steps, strict=True))

    def places(self, numbers: Sequence[int]) -> list[int]:
        """Return the positions in `steps` of load steps with these numbers, or raise SceneError."""
        for number in numbers:
            if number not in self.indices:
                allowed = ", ".join(map(str, self.indices)) or "none"
                raise SceneError(f"step: found {number}, allowed: {allowed}")
        return [self.indices.index(number) for number in numbers]

    @property
    def facts(self) -> dict[str, Any]:
        """Root attributes that are a single number or text, by name."""
        return {name: self.head[name] for name in scalar_names([self.head])}

    def some(self, steps: slice | list[int], **changes: Any) -> "Result":
        """Return a copy with some load steps, by position, and changed attributes."""
        places = range(len(self.steps))[steps] if isinstance(steps, slice) else steps
        names = "steps", "indices", "fields"
        picked: dict[str, Any] = {name: [getattr(self, name)[k] for k in places] for name in names}
        return replace(self, **picked, **changes)

    def only(
        self, indices: Sequence[int] | None = None, fields: Sequence[str] | None = None
    ) -> "Result":
        """Return a copy with some load steps, by number, and fields, by name; default: all."""
        chosen = self if indices is None else self.some(self.places(indices))
        if fields is None:
            return chosen
        present = sorted({name for of_step in self.fields for name in of_step})
        for name in fields:
            if name not in present:
                raise SceneError(f"fields: found {name}, allowed: {', '.join(present) or 'none'}")
        kept = [
            {name: of_step[name] for name in of_step if name in fields} for of_step in chosen.fields
        ]
        return replace(chosen, fields=kept)

    @property
    def missing_loads(self) -> str:
        """Sentence that lists the loads of the scene, numbered from 1, that the result lacks."""
        key, loads = self.scene.load.prescribed
        missing = [
            f"{k + 1} ({key} = {format_quantity(load)})"
            for k, load in enumerate(loads)
            if k not in self.indices
        ]
        if not missing:
            return "all loads are finished"
        return f"loads {', '.join(missing)} of {len(loads)} are missing"


def group_of(index: int) -> str:
    """Return the name of the group of a load step in a file, from the number of the load."""
    return f"steps/{index:04d}"


def missing_fields(result: Result, names: Sequence[str]) -> SceneError:
    """Return the error that a result has none of these fields."""
    where = f"in {result.path}" if result.path else "kept"
    quoted = ", ".join(f'"{name}"' for name in names)
    return SceneError(
        f"{', '.join(names)}: not {where}, allowed: fields = [{quoted}, ...] where it is solved"
    )
