"""What an erratum is: what is printed, what is right, and a function that shows it."""

from collections.abc import Callable
from dataclasses import dataclass

from ..rows import Rows


@dataclass(frozen=True)
class Erratum:
    """printed, right: text; show: function of {study: rows}, how our numbers show it, "" while they
    do not reach that far."""

    printed: str
    right: str
    show: Callable[[dict], str]

    def row(self, tables: dict[str, Rows]) -> dict | None:
        """{"printed", "right", "shown"}; None while some study has no rows and this erratum cannot
        do without."""
        try:
            shown = self.show(tables)
        except (ValueError, TypeError, IndexError):
            if all(tables.values()):
                raise
            return None
        return {"printed": self.printed, "right": self.right, "shown": shown} if shown else None


class Errata(list):
    """The errata of a file, in order; the methods are decorators, by what is printed and what is
    right."""

    def add(self, printed: str, right: str) -> Callable:
        """The function of {study: rows} shows this erratum."""

        def added(show: Callable[[dict], str]) -> Callable[[dict], str]:
            self.append(Erratum(printed, right, show))
            return show

        return added

    def computed(self, printed: str, right: str) -> Callable:
        """The function shows this erratum by a computation of its own."""

        def added(show: Callable[[], str]) -> Callable[[], str]:
            self.add(printed, right)(lambda tables: show())
            return show

        return added
