"""All kinds of search, by what a checkpoint calls them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from .area import AreaSearch
from .closing import Closing
from .gap import ApproachSearch, GapSearch
from .opening import Opening
from .search import Search

SEARCHES: dict[str, type[Search]] = {
    search.kind: search for search in (AreaSearch, GapSearch, ApproachSearch, Opening)
}


def numbers_of(search: Search | Closing) -> dict[str, Any]:
    """What makes a checkpoint; a Closing has no state."""
    return {"kind": search.kind} | (asdict(search) if isinstance(search, Search) else {})


def restored(numbers: dict[str, Any]) -> Search:
    """The Search of a checkpoint."""
    return SEARCHES[numbers["kind"]].restored(
        {name: value for name, value in numbers.items() if name != "kind"}
    )
