"""The contact of a stored load, restored from its fields to compute further observables."""

from dataclasses import replace

import numpy as np

from ..bodies import body_of
from ..certificate.certificate import Certificate
from ..contact.contact import Contact
from ..laws import attraction_of
from ..output.result import Result, missing_fields
from ..parallel.comm import SerialComm
from ..surface import Surface, grid_of

ROUNDING = 1e-6  # relative, of stored pressures


def restored_contact(result: Result) -> Contact:
    """Return the Contact of a Result with one load, on one process. Energy, approach and errors are
    nan, as fields do not tell them; `surface.h` is None without stored heights.
    """
    step = result.steps[0]
    attributes = result.surface
    fields = _stored_fields(result)
    scene = result.scene
    n = [*attributes["n"]]
    free = scene.surface.free
    axis = None if any(free) or 1 in n else _constant_axis(fields["pressure"], fields["gap"])
    if axis is not None:  # solved along the other one alone
        n[axis] = 1
        fields = {
            name: values[:1] if axis == 0 else values[:, :1] for name, values in fields.items()
        }
    grid = grid_of(tuple(n), attributes["physical_sizes"], SerialComm(), free=free)
    heights = fields.get("heights")
    n_x, n_y = attributes["n"]
    surface = Surface(
        grid, None, (n_x, n_y), attributes["h_rms"], attributes["g_rms"], rows=(0, n_x)
    )
    surface = replace(surface, prepared=tuple(attributes.get("prepared") or ()))
    if heights is not None:
        surface = replace(surface, h=heights / -surface.height_unit)
    E_star = scene.material.E_star
    hardness = scene.material.hardness
    yields = (1 - ROUNDING) * (hardness or np.inf)
    certificate = Certificate(
        contact=int(np.count_nonzero(fields["pressure"] > 0)),
        yielded=int(np.count_nonzero(fields["pressure"] >= yields)),
        gap_mean=float(fields["gap"].mean(dtype=float)) / surface.height_unit,
        energy=np.nan,
        attraction=(step.get("attraction") or 0.0) / (E_star * surface.slope),
        stability=step.get("stability") or np.nan,
    )
    beyond = [(0, cell - points) for cell, points in zip(grid.shape, fields["gap"].shape)]
    return Contact(
        surface,
        E_star,
        step["p"],
        g=np.pad(fields["gap"] / surface.height_unit, beyond),
        p=np.pad(fields["pressure"] / (E_star * surface.slope), beyond),
        status=step["status"],
        certificate=certificate,
        accuracy=scene.solver.tolerance,
        lam_s=getattr(scene.surface, "lam_s", None),
        body=body_of(scene.material, free),
        hardness=hardness,
        attraction=attraction_of(scene.material),
    )


def _stored_fields(result: Result) -> dict[str, np.ndarray]:
    """Return pressure, gap and perhaps heights of a Result with one load; SceneError without."""
    stored = result.fields[0]
    missing = [name for name in ("pressure", "gap") if name not in stored]
    if missing:
        raise missing_fields(result, missing)
    return {name: stored[name].read() for name in ("pressure", "gap", "heights") if name in stored}


def _constant_axis(*fields: np.ndarray) -> int | None:
    """Return the first axis along which all fields are constant; None if there is none."""
    for axis in (0, 1):
        if all((values == values.take([0], axis)).all() for values in fields):
            return axis
    return None
