"""All pictures of a result: which there are, and the way to each."""

import textwrap
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..output.read import Result, read_result
from ..output.table import surface_line
from ..parallel.guard import one_line
from ..util.errors import GfmdError, SceneError
from .curves import curves
from .distributions import distributions, stored
from .drawn import Drawn
from .maps import SYMBOLS, maps
from .spectra import has_spectra, spectra
from .style import Picture, save, styled

MAX_STEPS = 4  # in maps, distributions and spectra where nobody says which
PANELS = ("contact", "pressure", "gap")
WHAT = ("maps", "distributions", "spectra", "curves", "contact", *SYMBOLS)
CHARACTERS = 19  # of a title, per inch
SUFFIXES = (".png", ".pdf", ".svg")
DRAWN = {
    "distributions": distributions,
    "spectra": spectra,
    "curves": curves,
}  # all others are maps


def plot(
    result: Any,
    what: Any = None,
    step: Any = None,
    window: Any = None,
    dpi: float | None = None,
    dimensionless: bool = False,
) -> Picture:
    """One picture of a result.

    Parameters
    ----------
    result : Result or path
        What `output.read.read_result` gives, or its file.
    what : str, optional
        "maps" (contact, pressure, gap), one of these or "heights", "displacement"; "distributions",
        "spectra", "curves" over the load; by default the first of them that there is.
    step : int or list of int, optional
        The numbers of load steps; by default all for curves, otherwise at most four, first and last
        among them.
    window : (x0, x1, y0, y1), optional
        The part of the cell that maps show, in the unit of its sizes or as texts such as "2 um".
    dpi : int, optional
        Of the print, for which maps have enough pixels.
    dimensionless : bool
        Pressures over E* g_rms and lengths over h_rms though the result has units.

    Returns
    -------
    matplotlib.figure.Figure

    Raises SceneError for what the result does not have, GfmdError where its fields cannot be read.
    """
    result = result if isinstance(result, Result) else read_result(result)
    there = _there(result)
    what = what or next(iter(there), "maps")
    if what not in there:
        allowed = ", ".join(there) or "nothing, it has no finished load step"
        raise SceneError(
            f"what: found {what!r}, allowed: {allowed}"
            + (
                ""
                if len(there) > 1
                else " (maps and distributions need output.fields, spectra output.distributions)"
            )
        )
    with styled():
        fig = Picture(layout="constrained" if what in DRAWN else "compressed")
        try:
            drawn = Drawn(result, chosen_steps(result, what, step), window, dpi, dimensionless)
            if what in DRAWN:
                DRAWN[what](fig, drawn)
            else:
                maps(
                    fig,
                    drawn,
                    [name for name in PANELS if name in there] if what == "maps" else [what],
                )
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise GfmdError(f"drawing {result.path}: {one_line(error)}") from error
        fig.suptitle(
            textwrap.fill(_title(result, drawn, what), int(CHARACTERS * fig.get_figwidth())),
            x=0.01,
            ha="left",
        )
    return fig


def figures(result: Any, what: Any = None, **how: Any) -> dict[str, Picture]:
    """{name: picture} of the maps, distributions, spectra and curves that there are, or of `what`
    (names); how: see plot."""
    result = result if isinstance(result, Result) else read_result(result)
    if not result.steps:
        raise SceneError(f"{result.path}: no finished load step yet, nothing to draw")
    wanted = [what] if isinstance(what, str) else what
    if not wanted:
        there = [name for name in _there(result) if name in WHAT[:4]]
        alone = len(result.steps) == 1 and len(there) > 1
        wanted = (
            ["maps"]
            if how.get("window")
            else [name for name in there if name != "curves" or not alone]
        )
    return {name: plot(result, name, **how) for name in wanted}


def plot_result(file: Any, where: Any = None, what: Any = None, **how: Any) -> list[Path]:
    """Draw and save; returns the paths.

    file: a path or a Result; where: a folder, made if only itself is missing, or a file .png, .pdf
    or .svg (of several pictures each has its name added); by default they lie beside the result as
    RESULT_NAME.png. what, how: see figures and plot. Raises SceneError and GfmdError as plot, and
    where the pictures cannot be written.
    """
    result: Any = file if isinstance(file, Result) else read_result(file)
    where = Path(where or result.path.with_suffix(SUFFIXES[0]))
    as_file = where.suffix.lower() in SUFFIXES and not where.is_dir()
    folder = where.parent if as_file else where
    try:
        if not as_file:
            folder.mkdir(exist_ok=True)
        if not folder.is_dir():
            raise SceneError(f"-o: the folder {folder} does not exist")
    except OSError as error:
        raise SceneError(f"-o: pictures cannot go to {folder} ({one_line(error)})") from None
    drawn = figures(result, what, **how)
    paths = []
    for name, fig in drawn.items():
        one = where if as_file and len(drawn) == 1 else None
        paths.append(
            one or (where.with_stem(f"{where.stem}_{name}") if as_file else folder / f"{name}.png")
        )
        try:
            save(fig, paths[-1], how.get("dpi"))
        except OSError as error:
            raise GfmdError(f"writing {paths[-1]}: {one_line(error)}") from error
    return paths


def chosen_steps(result: Result, what: Any, step: Any = None) -> list[int]:
    """Places in result.steps of the load steps that a picture shows. Raises SceneError for numbers
    that it does not have."""
    if step is not None:
        numbers = [int(number) for number in np.atleast_1d(step)]
        unknown = [number for number in numbers if number not in result.indices]
        if unknown:
            raise SceneError(
                f"step: found {unknown[0]}, allowed: {', '.join(map(str, result.indices))}"
            )
        return [result.indices.index(number) for number in numbers]
    able = [k for k in range(len(result.steps)) if _shows(result, k, what)]
    if what == "heights":
        return able[:1]  # the same under all loads
    if what == "curves" or len(able) <= MAX_STEPS:
        return able
    return [able[k] for k in np.linspace(0, len(able) - 1, MAX_STEPS).round().astype(int)]


def _shows(result: Result, k: int, what: Any) -> bool:
    """Whether a picture can show the k-th step."""
    step, fields = result.steps[k], result.fields[k]
    contact = {"pressure", "gap"} & set(fields)
    if what == "spectra":
        return has_spectra(step)
    if what == "distributions":
        return bool(contact) or any(stored(step, name) for name in ("pressure", "gap", "patches"))
    return (
        what == "curves" or bool(contact)
        if what in ("maps", "contact", "curves")
        else what in fields
    )


def _there(result: Result) -> list[str]:
    """Names of the pictures that this result has."""
    return [what for what in WHAT if any(_shows(result, k, what) for k in range(len(result.steps)))]


def _title(result: Result, drawn: Drawn, what: Any) -> str:
    title = result.path.stem if result.path else "contact"
    with suppress(tomllib.TOMLDecodeError):
        title = tomllib.loads(result.scene_toml).get("title") or title
    left = len(result.steps) - len(drawn.chosen) if what != "heights" else 0
    out = f"; {left} of {len(result.steps)} loads not shown" if left else ""
    surface = surface_line(
        {
            key: value
            for key, value in result.surface.items()
            if key in ("n", "physical_sizes", "h_rms", "unit")
        }
    )
    for plain, printed in ((" x ", " × "), (" um", " µm"), ("h_rms", r"$\bar{h}$")):
        surface = surface.replace(plain, printed)
    return f"{title}: {surface}{out}"
