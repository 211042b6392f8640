"""Pictures of results: which there are, and which panels and loads each shows."""

import tomllib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple, NoReturn

import numpy as np

from ..output.read import read_result
from ..output.result import Result
from ..output.summary import is_positive
from ..plotting.curves import OVERVIEW, QUANTITIES, curves, drawn_sweep, is_tight
from ..plotting.maps import FIELDS, maps, title_of, window_of
from ..plotting.spectra import DISTRIBUTIONS, SPECTRA, distributions, spectra
from ..plotting.style import COLUMN_WIDTH, Page, Picture, Units, styled
from ..plotting.theory import theory_beside, theory_of
from ..scene.explain import suggested
from ..util.errors import GfmdError, SceneError, reason

MAX_STEPS = 4  # in maps, distributions and spectra unless `step` is given


class Kind(NamedTuple):
    """A picture: its page, one of PAGES, and numbers and fields of which each panel needs one."""

    page: str
    panels: Mapping[str, tuple[str, ...]]


MAPS = {name: (name,) for name in FIELDS} | {"contact": ("pressure", "gap")}
PAGES = {
    "maps": {name: MAPS[name] for name in ("contact", "pressure", "gap")},
    "distributions": {name: (*MAPS.get(name, ()), f"{name}_edges") for name in DISTRIBUTIONS},
    "spectra": {name: (f"{name}_q", f"{name}_r") for name in SPECTRA},
    "curves": {name: (name,) for name in OVERVIEW} | {"p": ("time",)},
}
PICTURES = (
    {name: Kind(name, panels) for name, panels in PAGES.items()}
    | {name: Kind("maps", {name: keys}) for name, keys in MAPS.items()}
    | {name: Kind("curves", {name: (name,)}) for name in QUANTITIES}
)


def kind_of(name: str) -> Kind:
    """Return the kind of a picture; a name not in PICTURES is taken as a number of a load."""
    return PICTURES.get(name) or Kind("curves", {name: (name,)})


def plot(
    result: Any,
    what: Any = None,
    step: Any = None,
    window: Any = None,
    dpi: float | None = None,
    dimensionless: bool = False,
    ax: Any = None,
    columns: int | None = None,
    persson: bool = False,
) -> Picture:
    """Draw one picture of a result, or the curves of several.

    Parameters
    ----------
    result : Solutions, Solution or path, or several
        Solved loads, or the path of a result file. Several, as a list or as a dict with names for
        the legend, can only be drawn as curves.
    what : str, optional
        "maps" (pressure and gap), or a single map: "pressure", "gap", "contact", "heights",
        "displacement", "plastic", "dent"; "distributions"; "spectra"; "curves" against the load, or
        a single curve: "a_r", "kappa", "gap_mean", "approach", or any other number of the loads,
        such as "conductance" or "critical_gap_x". Default: the first that the result has of maps,
        distributions, spectra, curves, and single maps and curves. Curves of more than six results
        show the mean and the standard deviation.
    step : int or list of int, optional
        Numbers of the load steps to draw. Default: all for curves, otherwise at most four, the
        first and the last among them.
    window : (x0, x1, y0, y1), optional
        Part of the cell that maps show, in the unit of its sizes or as texts such as "2 um".
    dpi : int, optional
        Resolution of the print, for which maps get enough pixels.
    dimensionless : bool
        Draw pressures over E* g_rms and lengths over h_rms even if the result has units.
    ax : matplotlib.axes.Axes, optional
        Axes to draw on, for pictures of one panel; they get no legend. Default: a new figure.
    columns : int, optional
        Panels beside each other. 1 puts them below each other, for one column of a journal (85 mm).
    persson : bool
        Draw Persson's theory beside a measured, periodic (also mirrored) map, too: the area by its
        g_rms, and the gap by its spectrum if the result has the distribution "heights_spectrum".

    Returns
    -------
    matplotlib.figure.Figure
        A new figure, or that of `ax`. A new one is saved at print resolution unless savefig is told
        otherwise; a notebook shows it once, wherever in a cell it is made.

    Raises
    ------
    SceneError
        If the result does not have this picture or these load steps, or an argument is wrong.
    GfmdError
        If its fields cannot be read.
    """
    results = _results(result)
    if not results:
        raise SceneError("result: an empty list; give a result or several")
    if what is None:
        what = next((name for name in PICTURES if _can_draw(name, results, step)), "maps")
    if not _can_draw(what, results, step):
        _refuse(what, results, step)
    page = _arranged(_page(what, results, step, window, dpi, dimensionless, persson), columns)
    if ax is not None and len(page.panels) != 1:
        raise SceneError(
            f"ax: {what!r} has {len(page.panels)} panels, and one axes takes one panel, such as"
            ' "pressure" of one load, or "a_r"'
        )
    whole = next(iter(results.values()))
    title = _title(whole, what, step) if len(results) == 1 else ""
    try:
        if ax is None:
            return page.picture(title)
        with styled():
            page.panels[0](ax)
    except OSError as error:
        raise GfmdError(f"drawing {whole.path}: {reason(error)}") from error
    return ax.figure


def _page(
    what: str,
    results: Mapping[str, Result],
    step: Any,
    window: Any,
    dpi: float | None,
    dimensionless: bool,
    persson: bool,
) -> Page:
    """Return the page of a picture, with the panels that any of the results has."""
    for result in results.values():
        window_of(result.surface, window)  # refuses a wrong window of any picture
    page, needed = kind_of(what)
    chosen = {name: chosen_steps(result, what, step) for name, result in results.items()}
    loads = [result.some(chosen[name]) for name, result in results.items()]
    panels = [
        panel
        for panel, keys in needed.items()
        if any(_steps(result, {panel: keys}) for result in loads)
    ]
    if page == "curves":
        sweeps = [
            drawn_sweep(
                name,
                result,
                chosen[name],
                _units_of(result, dimensionless),
                theory_beside(result, persson),
            )
            for name, result in results.items()
        ]
        return curves(sweeps, panels)
    (result,) = results.values()
    (drawn,) = loads
    units = _units_of(result, dimensionless)
    if page == "distributions":
        return distributions(drawn, panels, units, theory_beside(result, persson))
    if page == "spectra":
        return spectra(drawn, panels, units)
    if "pressure" in panels and what == "maps":
        panels.remove("contact")  # which the pressure shows, too
    return maps(drawn, panels, units, window_of(result.surface, window), dpi)


def _units_of(result: Result, dimensionless: bool) -> Units:
    """Return the scales of a result, of heights by the theory of its surface."""
    theory = theory_of(result.readable_scene, result.surface)
    return Units(result.surface, result.steps, theory.height if theory else None, dimensionless)


def _arranged(page: Page, columns: int | None) -> Page:
    """Return a page with this number of columns; a single one is that of a journal."""
    if columns is None:
        return page
    number = len(page.panels)
    if not 1 <= columns <= number:
        raise SceneError(
            f"columns: found {columns}, allowed: from 1 to {number}, the number of panels"
        )
    return replace(page, columns=columns, width=COLUMN_WIDTH if columns == 1 else page.width)


def _can_draw(what: Any, results: Mapping[str, Result], step: Any) -> bool:
    """Whether every result has a load step for the picture `what`; of several, only curves."""
    if not isinstance(what, str) or not (len(results) == 1 or kind_of(what).page == "curves"):
        return False
    return all(chosen_steps(result, what, step) for result in results.values())


def _refuse(what: Any, results: Mapping[str, Result], step: Any) -> NoReturn:
    """Raise SceneError with the names of the pictures that the results have."""
    possible = [name for name in PICTURES if _can_draw(name, results, step)]
    allowed = ", ".join(possible) or "nothing, it has no finished load step"
    if "maps" not in possible:
        allowed += " (maps need output.fields, spectra output.distributions, distributions either)"
    of = "" if step is None else f" of step {step}"
    is_misspelt = isinstance(what, str) and what not in PICTURES
    hint = suggested(what, PICTURES) if is_misspelt else ""
    raise SceneError(f"what: found {what!r}{of}, {hint}allowed: {allowed}")


def _results(argument: Any) -> dict[str, Result]:
    """Return {name in the legend: Result} of the argument `result` of plot; paths are read."""
    if isinstance(argument, Mapping):
        return {str(name): result_of(solution) for name, solution in argument.items()}
    if not isinstance(argument, list | tuple):
        return {"": result_of(argument)}
    results = map(result_of, argument)
    return {f"{k}: {_name(result)}": result for k, result in enumerate(results, 1)}


def result_of(solution_or_path: Any) -> Result:
    """Return the Result of a Solution or of Solutions, or read it from the file at a path."""
    result = getattr(solution_or_path, "result", solution_or_path)  # of a Solution
    return result if isinstance(result, Result) else read_result(result)


def chosen_steps(result: Result, what: Any, step: Any) -> list[int]:
    """Return the indices of steps a picture shows; default: all for curves, the first for
    "heights", else at most four.
    """
    kind = kind_of(what)
    able = _steps(result, kind.panels)
    if step is not None:
        if not np.size(step):
            raise SceneError("step: an empty list; give the number of a load step or several")
        return [k for k in result.places(np.atleast_1d(step).tolist()) if k in able]
    if what == "heights":
        return able[:1]  # the same under all loads
    if kind.page == "curves" or len(able) <= MAX_STEPS:
        return able
    return [able[k] for k in np.linspace(0, len(able) - 1, MAX_STEPS).round().astype(int)]


def _steps(result: Result, panels: Mapping[str, tuple[str, ...]]) -> list[int]:
    """Return the indices of the load steps that have a number or field of any of the panels."""
    keys = {key for needed in panels.values() for key in needed}
    return [
        k
        for k, (step, fields) in enumerate(zip(result.steps, result.fields))
        if any(
            key in fields
            or is_positive(step.get(key))
            or np.ndim(step.get(key, 0))
            or is_tight(key, step)
            for key in keys
        )
    ]


def _name(result: Result) -> str:
    """Return the title of the result's scene, or the name of its file, or "contact"."""
    title = ""
    with suppress(tomllib.TOMLDecodeError):
        title = tomllib.loads(result.scene_toml).get("title", "")
    return title or (result.path.stem if result.path else "contact")


def _title(result: Result, what: str, step: Any) -> str:
    """Return the title of a figure: title and surface of the result, number of loads left out."""
    number = len(result.steps)
    left = number - len(chosen_steps(result, what, step)) if what != "heights" else 0
    out = f"; {left} of {number} loads not shown" if left else ""
    return title_of(_name(result), result.surface) + out
