"""The content of a result file, or of a solution in memory."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..scene import ArrayScene, Scene
from ..scene.model import parse_toml
from ..util.errors import SceneError
from ..util.quantities import format_quantity
from .fields import Slab
from .numbers import names_of

FORMAT_VERSION = 3
# (table, key) that scenes in older files may have, and that changed no result
WITHDRAWN = (("machine", "checkpoint_seconds"),)


@dataclass(frozen=True)
class Result:
    """The content of a result file, or of a solution in memory.

    Attributes
    ----------
    path : Path or None
        Of the file; None in memory.
    surface : dict
        Attributes of the surface.
    steps : list of dict
        Attributes of each load step.
    indices : list of int
        Numbers of the load steps.
    status : str
        Of the whole run; "running" or "interrupted" if it is not finished.
    head : dict
        Attributes of the root.
    fields : list of dict
        Fields of each load step by name: Stored in a file, Slab in memory.
    folder : Path or None
        Of a run that is not finished.
    notes : tuple of str
        What a reader should know, a line each.
    version : int
        Format version, which a pickle keeps.
    """

    path: Path | None
    surface: dict
    steps: list[dict]
    indices: list[int]
    status: str
    head: dict
    fields: list[dict[str, Any]] = field(repr=False)
    folder: Path | None = None
    notes: tuple[str, ...] = ()
    version: int = field(default=FORMAT_VERSION, repr=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        if state.get("version") != FORMAT_VERSION:
            raise SceneError("a pickle of another version of hpc_gfmd, allowed: of this one")
        vars(self).update(state)

    @property
    def scene_toml(self) -> str:
        """The scene that was solved."""
        return str(self.head.get("scene", ""))

    @property
    def scene(self) -> Scene:
        """The same; where heights were an array, with the sizes and the boundary alone as its
        surface."""
        table = parse_toml(self.scene_toml, str(self.path))
        for name, key in WITHDRAWN:
            if isinstance(table.get(name), dict):
                table[name].pop(key, None)
        return (Scene if "kind" in table.get("surface", {}) else ArrayScene).from_dict(
            table, str(self.path)
        )

    @property
    def remarks(self) -> list[str]:
        """What to say beside what was made of it, a line each."""
        unfinished = f"! the run is {self.status}: only its finished load steps are there"
        return [f"note: {note}" for note in self.notes] + [unfinished] * (self.folder is not None)

    @property
    def numbered(self) -> dict[int, dict]:
        """The attributes of the load steps, by their numbers."""
        return dict(zip(self.indices, self.steps, strict=True))

    @property
    def groups(self) -> dict[str, dict]:
        """The attributes of the load steps, by their groups in a file."""
        return {group_of(index): step for index, step in self.numbered.items()}

    def places(self, numbers: Sequence[int]) -> list[int]:
        """Return where load steps of these numbers are in `steps`. Raises SceneError for those that
        are not there."""
        for number in numbers:
            if number not in self.indices:
                allowed = ", ".join(map(str, self.indices)) or "none"
                raise SceneError(f"step: found {number}, allowed: {allowed}")
        return [self.indices.index(number) for number in numbers]

    @property
    def datasets(self) -> dict[str, Any]:
        """The fields by their places in a file, heights once: Stored, or the slab in memory."""
        places = {"heights": "surface"}
        return {
            f"{places.get(name, group)}/{name}": field.data if isinstance(field, Slab) else field
            for group, fields in zip(self.groups, self.fields, strict=True)
            for name, field in fields.items()
        }

    @property
    def facts(self) -> dict[str, Any]:
        """What the head says in one number or text."""
        return {name: self.head[name] for name in names_of([self.head])}

    def some(self, steps: slice | list[int], **changes: Any) -> "Result":
        """Return a result with some of the load steps.

        Parameters
        ----------
        steps : slice or list of int
            Their places in `steps`.
        **changes
            Attributes to replace.

        Returns
        -------
        Result
            A copy; this one stays as it is.
        """
        places = range(len(self.steps))[steps] if isinstance(steps, slice) else steps
        names = "steps", "indices", "fields"
        picked: dict[str, Any] = {name: [getattr(self, name)[k] for k in places] for name in names}
        return replace(self, **picked, **changes)

    def only(
        self, indices: Sequence[int] | None = None, fields: Sequence[str] | None = None
    ) -> "Result":
        """Return a result with some of the load steps and fields.

        Parameters
        ----------
        indices : sequence of int, optional
            Numbers of the load steps; default: all.
        fields : sequence of str, optional
            Names of the fields; default: all.

        Returns
        -------
        Result
            A copy; this one stays as it is.

        Raises
        ------
        SceneError
            For those that the result does not have.
        """
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
        """Which of the loads that its scene asks for are not there, as a text."""
        key, loads = self.scene.load.given
        missing = [
            f"{k + 1} ({key} = {format_quantity(load)})"
            for k, load in enumerate(loads)
            if k not in self.indices
        ]
        if not missing:
            return "all loads are finished"
        return f"loads {', '.join(missing)} of {len(loads)} are missing"


def group_of(index: int) -> str:
    """Return the group of a load step in a file."""
    return f"steps/{index:04d}"
