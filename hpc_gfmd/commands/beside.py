"""Numbers of a result beside the theory of its surface."""

from typing import Any

from ..output.result import Result
from ..output.summary import estimate
from ..util.errors import SceneError

COMPARED = ("a_r", "gap_mean", "approach")
NO_SPECTRUM = (
    'the mean gap of a map needs its spectrum: output.distributions = ["heights_spectrum"]'
)


def to_theory(result: Result) -> dict[str, Any]:
    """Return "name" of the theory (with a map's g_rms and waves) and "steps" above 0: "step", "p"
    and its numbers.
    """
    from ..plotting.theory import theory_beside

    theory = theory_beside(result, of_maps=True)
    if theory is None or not theory.curves:
        raise SceneError(
            "--persson: found a surface without a theory, allowed: a rough map that is periodic or"
            " mirrored on a half-space without adhesion, a sphere or a wave along one axis"
        )
    steps = [
        {"step": index, "p": step["p"]}
        | {name: float(curve(step["p"])) for name, curve in theory.curves.items()}
        for index, step in result.numbered.items()
        if step["p"] > 0
    ]
    return {"name": theory.text or theory.name, "steps": steps}


def theory_text(result: Result, theory: dict[str, Any]) -> str:
    """Return what `to_theory` has found, beside the numbers of the result, as text."""
    from ..runs.table import RESULTS, aligned, column_scale

    names = {name for step in theory["steps"] for name in step}
    solved = [result.numbered[step["step"]] for step in theory["steps"]]
    columns = [["step", "", *(str(step["step"]) for step in theory["steps"])]]

    def add(heading: str, name: str, values: list[float], steps: list[dict]) -> None:
        scale, unit = column_scale(name, values, result.surface)
        texts = [estimate(value / scale, name, step) for value, step in zip(values, steps)]
        columns.append([heading, unit, *texts])

    add("p", "p", [step["p"] for step in solved], solved)
    for name in filter(names.__contains__, COMPARED):
        corrected = name == "a_r" and all(step.get("a_r_corrected") for step in solved)
        shown = "a_r_corrected" if corrected else name
        add(
            "a_r, corrected" if corrected else RESULTS[name],
            shown,
            [s[shown] for s in solved],
            solved,
        )
        add("theory", name, [step[name] for step in theory["steps"]], [{}] * len(solved))
    lines = [f"theory: {theory['name']}", *aligned([list(row) for row in zip(*columns)])]
    is_map = result.surface.get("kind") in ("file", "array")
    return "\n".join([*lines, *[NO_SPECTRUM] * (is_map and "gap_mean" not in names)])
