"""The solvers' own parameters, [solver.options] of a scene."""

from .errors import SceneError


def read_options(solver, options, allowed):
    """The given options as floats. allowed: {name: (smallest, largest value)}.

    Raises SceneError for an unknown name or a value out of bounds.
    """
    for name, value in options.items():
        if name not in allowed:
            known = ", ".join(allowed) or "none"
            raise SceneError(f"solver.options: found {name!r}, allowed for the solver {solver!r}: {known}")
        low, high = allowed[name]
        if not low <= value <= high:
            raise SceneError(f"solver.options.{name}: found {value!r}, allowed: a number from {low:g} to {high:g}")
    return {name: float(value) for name, value in options.items()}
