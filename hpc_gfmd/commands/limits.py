"""Extrapolation of a result to the thermodynamic, fractal and continuum (TFC) limits."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from ..output.result import Result
from ..output.summary import converged
from ..theory import tfc
from ..util.errors import SceneError

# observables that are extrapolated, with the name of their estimated relative error
OBSERVABLES = {"kappa": "a_r_error", "gap_over_h_rms": "gap_error"}
SCATTER = (
    "+- contains the estimated error of this run and, where known, of the coefficients, not the"
    " scatter between realisations"
)


def to_limits(result: Result, table: str = "ours") -> dict:
    """Extrapolate contact area and mean gap of the load steps of a self-affine surface to the TFC
    limit.

    table: as `theory.tfc.table_of` takes it. Returns "table": its name; "steps": dicts with "step",
    "p_star" and for "kappa" and "gap_over_h_rms" a dict: "value", "sigma" and either "refused" (the
    reason) or corrections, "extrapolated", "extrapolated_sigma", "converged", "notes".
    """
    surface = result.surface
    missing = [
        name for name in ("hurst", *tfc.RATIOS) if not isfinite(surface.get(name, float("nan")))
    ]
    if missing:
        raise SceneError(
            f"--tfc: needs a self-affine surface; this one, of kind"
            f" {surface.get('kind', 'unknown')!r}, has no {', '.join(missing)}"
        )
    parameters: dict[str, Any] = {key: float(surface[key]) for key in ("hurst", *tfc.RATIOS)}
    parameters["table"] = tfc.table_of(table)
    steps = [
        {"step": index, "p_star": step["p_star"]}
        | {
            observable: _limit(step, observable, error_name, parameters)
            for observable, error_name in OBSERVABLES.items()
            if observable in step
        }
        for index, step in result.numbered.items()
    ]
    return {"table": table, "steps": steps}


def limits_text(limits: dict) -> str:
    """Return `limits`, from `to_limits`, as text: a line per number and load step, then notes."""
    lines = [
        "extrapolated to the thermodynamic, fractal and continuum limits with the coefficients"
        f" {limits['table']}"
    ]
    notes = [SCATTER]
    for step in limits["steps"]:
        for observable in OBSERVABLES:
            limit = step.get(observable)
            if limit is None:
                continue
            value = limit["value"], limit["sigma"]
            if "refused" in limit:
                head = _value_text(observable, step["p_star"], value)
                lines.append(f"  {head}: not corrected: {limit['refused']}")
                continue
            extrapolated = limit["extrapolated"], limit["extrapolated_sigma"]
            line = extrapolation_text(observable, step["p_star"], value, limit, extrapolated)
            lines.append(f"  {line}")
            if not limit["converged"]:
                notes.append(f"step {step['step']}: NOT CONVERGED")
            notes += limit["notes"]
    return "\n".join([*lines, *(f"note: {note}" for note in dict.fromkeys(notes))])


def _limit(
    step: dict, observable: str, error_name: str, parameters: dict[str, Any]
) -> dict[str, Any]:
    """Extrapolate one observable of a step, see `to_limits`; error_name: of its relative error."""
    value = step[observable]
    relative_error = step.get(error_name)
    sigma = None
    if relative_error is not None and isfinite(relative_error):
        sigma = abs(value * relative_error)
    limit = {"value": value, "sigma": sigma}
    try:
        extrapolated, sigma_extrapolated, terms = tfc.extrapolate(
            value, observable, p_star=step["p_star"], sigma=sigma, **parameters
        )
    except SceneError as refusal:
        return limit | {"refused": str(refusal)}
    return limit | {
        **terms.numbers,
        "correction_sigma": terms.sigma,
        "extrapolated": extrapolated,
        "extrapolated_sigma": sigma_extrapolated,
        "converged": converged(step),
        "notes": list(terms.notes),
    }


def extrapolation_text(
    observable: str,
    p_star: float,
    value: tuple[float, float | None],
    corrections: Mapping[str, Any],
    extrapolated: tuple[float, float | None],
) -> str:
    """Return one line: a value, what is added to it (minus its corrections), and its limit."""
    terms = ", ".join(f"{i} {-corrections[f'correction_{i}']:+.4f}" for i in "tfc")
    head = _value_text(observable, p_star, value)
    return f"{head}; {terms} -> {_with_sigma(*extrapolated)}"


def _value_text(observable: str, p_star: float, value: tuple[float, float | None]) -> str:
    return f"p* = {p_star:.4g}, {observable} = {_with_sigma(*value)}"


def _with_sigma(value: float, sigma: float | None) -> str:
    return f"{value:.4f}" + (f" +- {sigma:.1g}" if sigma is not None else "")
