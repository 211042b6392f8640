"""What an erratum is: what is printed, what is right, and a function that shows it."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Erratum:
    """printed, right: text; show: function of {study: rows}, how our numbers show it, "" while they do not reach that far."""

    printed: str
    right: str
    show: Callable[[dict], str]

    def row(self, tables) -> dict | None:
        """{"printed", "right", "shown"}; None while some study has no rows and this erratum cannot do without."""
        try:
            shown = self.show(tables)
        except (ValueError, TypeError, IndexError):
            if all(tables.values()):
                raise
            return None
        return {"printed": self.printed, "right": self.right, "shown": shown} if shown else None


class Errata(list):
    """The errata of a file, in order."""

    def add(self, printed, right):
        """A decorator: the function shows this erratum."""

        def added(show):
            self.append(Erratum(printed, right, show))
            return show

        return added
