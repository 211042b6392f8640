"""All kinds of search, by what a checkpoint calls them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from .area import AreaSearch
from .gap import ApproachSearch, GapSearch
from .opening import Opening
from .search import Search

SEARCHES: dict[str, type[Search]] = {search.kind: search for search in (AreaSearch, GapSearch, ApproachSearch, Opening)}


def numbers_of(search: Search) -> dict[str, Any]:
    """What makes a checkpoint."""
    return {"kind": search.kind, **asdict(search)}


def restored(numbers: dict[str, Any]) -> Search:
    """The Search of a checkpoint."""
    return SEARCHES[numbers["kind"]].restored({name: value for name, value in numbers.items() if name != "kind"})
