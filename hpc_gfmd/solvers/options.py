"""The solvers' own parameters, [solver.options] of a scene."""

from collections.abc import Mapping

from ..scene.not_modelled import not_modelled
from ..util.errors import SceneError


def read_options(
    solver: str, options: Mapping[str, float], allowed: Mapping[str, tuple[float, float]]
) -> dict[str, float]:
    """Return the options of a solver as floats.

    Parameters
    ----------
    solver : str
        Its name.
    options : dict
        Numbers by their names, as in a scene.
    allowed : dict
        The smallest and largest value by name; where these are of type int, whole numbers.

    Returns
    -------
    dict
        The options that are given.

    Raises
    ------
    SceneError
        For an unknown name or a value that is not allowed.
    """
    for name, value in options.items():
        if name not in allowed:
            names = ", ".join(allowed) or "none"
            shown = ", ".join(filter(None, [repr(name), not_modelled(name)]))
            raise SceneError(
                f"solver.options: found {shown}, allowed for the solver {solver!r}: {names}"
            )
        low, high = allowed[name]
        kind = "a whole number" if isinstance(low, int) else "a number"
        if not low <= value <= high or (isinstance(low, int) and value % 1):
            raise SceneError(
                f"solver.options.{name}: found {value!r}, allowed: {kind} from {low:g} to {high:g}"
            )
    return {name: float(value) for name, value in options.items()}
