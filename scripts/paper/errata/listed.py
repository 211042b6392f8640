"""How a file lists its errata."""

from collections.abc import Callable


class Errata(list):
    """(printed, right, show) in order; show: function of {study: rows} that says how our numbers
    show it, "" while they do not reach that far."""

    def add(self, printed: str, right: str) -> Callable:
        """Decorate the function that shows an erratum."""

        def added(show: Callable[[dict], str]) -> Callable[[dict], str]:
            self.append((printed, right, show))
            return show

        return added
