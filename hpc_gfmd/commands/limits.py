"""The steps of a result taken to the thermodynamic, fractal and continuum (TFC) limits, where the
coefficients cover them."""

from math import isfinite
from typing import Any

from ..output.read import Result
from ..output.summary import converged
from ..theory import tfc
from ..util.errors import SceneError

# which are corrected, and the name of the estimated relative error of each
OBSERVABLES = {"kappa": "a_r_error", "gap_over_h_rms": "gap_error"}
SCATTER = (
    "+- holds the estimated error of this run and of the coefficients if known, not the scatter"
    " between realisations"
)


def to_limits(result: Result, table: str = "ours") -> dict:
    """Take the steps of a result to the limits.

    Returns {"table": its name, "steps": one dict per load step}: observable -> value, sigma, the
    corrections t, f, c and their sum, "extrapolated" with its sigma (of the value and, where the
    table has it, of the coefficients), notes; or "refused" with the reason.

    table: as of theory.tfc.table_of. Raises SceneError for a surface that is not self-affine.
    """
    surface = result.surface
    missing = [
        name for name in ("hurst", *tfc.RATIOS) if not isfinite(surface.get(name, float("nan")))
    ]
    if missing:
        raise SceneError(
            f"--tfc: found a surface of kind {surface.get('kind', 'unknown')!r} without"
            f" {', '.join(missing)}, allowed: results of a self-affine surface"
        )
    where: dict[str, Any] = {key: float(surface[key]) for key in ("hurst", *tfc.RATIOS)}
    where["table"] = tfc.table_of(table)
    steps = [
        {"step": index, "p_star": step["p_star"]}
        | {o: _limit(step, o, error, where) for o, error in OBSERVABLES.items() if o in step}
        for index, step in result.numbered.items()
    ]
    return {"table": table, "steps": steps}


def limits_text(limits: dict) -> str:
    """Write one line per observable and step, and the notes once."""
    lines = [
        "taken to the thermodynamic, fractal and continuum limits with the coefficients of:"
        f" {limits['table']}"
    ]
    notes = [SCATTER]
    for step in limits["steps"]:
        for name, found in ((o, step[o]) for o in OBSERVABLES if o in step):
            head = f"  p* = {step['p_star']:.4g}, {name} = {_shown(found['value'], found['sigma'])}"
            if "refused" in found:
                lines.append(f"{head}: not corrected: {found['refused']}")
                continue
            terms = ", ".join(f"{i} {-found[f'correction_{i}']:+.4f}" for i in "tfc")
            lines.append(
                f"{head}; {terms} -> {_shown(found['extrapolated'], found['extrapolated_sigma'])}"
            )
            notes += [f"step {step['step']}: NOT CONVERGED"] if not found["converged"] else []
            notes += found["notes"]
    return "\n".join([*lines, *(f"note: {note}" for note in dict.fromkeys(notes))])


def _limit(step: dict, observable: str, error: str, where: dict[str, Any]) -> dict[str, Any]:
    value, relative = step[observable], step.get(error)
    sigma = abs(value * relative) if relative is not None and isfinite(relative) else None
    found = {"value": value, "sigma": sigma}
    try:
        extrapolated, whole, terms = tfc.extrapolate(
            value, observable, p_star=step["p_star"], sigma=sigma, **where
        )
    except SceneError as refusal:
        return found | {"refused": str(refusal)}
    return found | {
        **terms.numbers,
        "correction_sigma": terms.sigma,
        "extrapolated": extrapolated,
        "extrapolated_sigma": whole,
        "converged": converged(step),
        "notes": list(terms.notes),
    }


def _shown(value: float, sigma: float | None) -> str:
    return f"{value:.4f}" + (f" +- {sigma:.1g}" if sigma is not None else "")
