"""Reference solutions, kept on disk, and true errors against them."""

import hashlib
import io
import json
from dataclasses import dataclass

import numpy as np

from hpc_gfmd.certificate.certificate import certify
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.util.caches import cache_folder, keep
from hpc_gfmd.util.errors import GfmdError

from .cases import Case
from .ours import Ours

ACCURACY = 1e-9  # asked of a reference
# estimate of the pressure error that a reference may have where rounding, or S with free edges,
# leaves no more
WORST = 1e-6


@dataclass(frozen=True)
class Reference:
    """a_r, gap_mean (cell size 1) and pressure field, float64, of a case; error: its own estimated
    pressure error."""

    a_r: float
    gap_mean: float
    pressure: np.ndarray
    error: float

    def errors(
        self, a_r: float, gap_mean: float, pressure: np.ndarray
    ) -> tuple[float, float, float]:
        """True relative errors (area, mean gap, L2 of the pressure field)."""
        difference = np.subtract(pressure, self.pressure, dtype=np.float64)
        return (
            abs(a_r / self.a_r - 1),
            abs(gap_mean / self.gap_mean - 1) if self.gap_mean else 0.0,
            self.pressure_error(difference),
        )

    def pressure_error(self, difference: np.ndarray) -> float:
        """L2 norm of a difference from the reference pressure over that of the reference."""
        return float(np.linalg.norm(difference) / np.linalg.norm(self.pressure))


def _stiffness(case: Case) -> str:
    """A number that tells a K of the same name from this one: <h, K h>."""
    surface = case.surface(np.dtype(np.float64))
    problem = Problem(surface.grid, surface.h, 1.0, body=case.body)
    g, p = (surface.grid.empty(problem.dtype) for _ in range(2))
    g[...] = 0
    return f"{certify(problem, g, p).uKu:.9e}"


def reference(case: Case) -> Reference:
    """The reference of a case, from the disk if it is there; solved in double precision otherwise.
    Raises GfmdError if that fails."""
    gap = case.gap()
    key = hashlib.sha256(
        gap.tobytes() + repr((case.p_star, case.body, _stiffness(case), ACCURACY)).encode()
    ).hexdigest()[:20]
    folder = cache_folder() / "bench"
    path, about = folder / f"{key}.npy", folder / f"{key}.json"
    try:
        return Reference(**json.loads(about.read_text()), pressure=np.load(path))
    except (OSError, ValueError, TypeError):
        pass
    solved = Ours(case, "double").solve(ACCURACY)
    error = float(solved.estimates[2])
    if not error < WORST:
        raise GfmdError(
            f"reference of {case}: {solved.status} at an estimated pressure error of {error:.1e},"
            f" allowed: below {WORST:g}"
        )
    numbers = {"a_r": solved.a_r, "gap_mean": solved.gap_mean, "error": error}
    content = io.BytesIO()
    np.save(content, solved.pressure)
    keep(path, content.getvalue())
    keep(about, json.dumps(numbers).encode())
    return Reference(**numbers, pressure=solved.pressure)
