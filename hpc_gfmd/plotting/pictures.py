"""All pictures of a result: which there are, and how they are drawn and saved."""

import tomllib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from ..output.read import read_result
from ..output.result import Result
from ..scene.explain import suggested
from ..util.errors import GfmdError, SceneError, reason
from .curves import OVERVIEW, QUANTITIES, curves, is_tight
from .maps import FIELDS, maps, title_of
from .spectra import DISTRIBUTIONS, SPECTRA, distributions, spectra
from .style import COLUMN_WIDTH, Page, Picture, legend, new_picture, save, styled
from .theory import theory_beside
from .view import View, good

MAX_STEPS = 4  # in maps, distributions and spectra unless `step` is given
SUFFIXES = (".png", ".pdf", ".svg")


class Kind(NamedTuple):
    """How a picture is made, and numbers and fields of its panels, of which a step needs one."""

    page: Callable[[Sequence[View], list[str]], Page]
    panels: Mapping[str, tuple[str, ...]]


def _curve(name: str) -> Kind:
    """Make the kind of picture that is one curve, of the number `name`, against the load."""
    return Kind(curves, {name: (name,)})


MAPS = {name: (name,) for name in FIELDS} | {"contact": ("pressure", "gap")}
PAGES = {
    "maps": Kind(maps, {name: MAPS[name] for name in ("contact", "pressure", "gap")}),
    "distributions": Kind(
        distributions, {name: (*MAPS.get(name, ()), f"{name}_edges") for name in DISTRIBUTIONS}
    ),
    "spectra": Kind(spectra, {name: (f"{name}_q", f"{name}_r") for name in SPECTRA}),
    "curves": Kind(curves, {name: (name,) for name in OVERVIEW} | {"p": ("time",)}),
}
PICTURES = (
    PAGES
    | {name: Kind(maps, {name: keys}) for name, keys in MAPS.items()}
    | {name: _curve(name) for name in QUANTITIES}
)


def kind_of(name: str) -> Kind:
    """Return the kind of a picture; a name not in PICTURES is taken as a number of a load."""
    return PICTURES.get(name) or _curve(name)


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
    kind = kind_of(what)
    with styled():
        view_of = partial(View, window=window, dpi=dpi, dimensionless=dimensionless)
        views = [
            view_of(shown, chosen_steps(shown, what, step), theory_beside(shown, persson), name)
            for name, shown in results.items()
        ]
        panels = [
            name
            for name, keys in kind.panels.items()
            if any(_steps(view.result, {name: keys}) for view in views)
        ]
        if "pressure" in panels and what == "maps":
            panels.remove("contact")  # which the pressure shows, too
        page = _arranged(kind.page(views, panels), columns)
        if ax is not None and len(page.panels) != 1:
            raise SceneError(
                f"ax: {what!r} has {len(page.panels)} panels, and one axes takes one panel, such as"
                ' "pressure" of one load, or "a_r"'
            )
        fig = ax.figure if ax else new_picture()
        try:
            if ax is None:
                page.draw(fig)
            else:
                page.panels[0](ax)
        except OSError as error:
            raise GfmdError(f"drawing {views[0].result.path}: {reason(error)}") from error
        if ax is None:
            narrow = fig.get_figwidth() <= COLUMN_WIDTH
            legend(
                fig,
                "outside lower center",
                columns=1 if narrow else 4,
                fewest=1 if page.images else 2,
            )
            if len(views) == 1:
                fig.suptitle(_title(views[0], what), x=0.01, ha="left", wrap=True)
    return fig


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
    if not isinstance(what, str) or not (len(results) == 1 or kind_of(what).page is curves):
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
        return {str(name): _result(solution) for name, solution in argument.items()}
    if not isinstance(argument, list | tuple):
        return {"": _result(argument)}
    results = map(_result, argument)
    return {f"{k}: {_name(result)}": result for k, result in enumerate(results, 1)}


def _result(solution_or_path: Any) -> Result:
    """Return the Result of a Solution or of Solutions, or read it from the file at a path."""
    result = getattr(solution_or_path, "result", solution_or_path)  # of a Solution
    return result if isinstance(result, Result) else read_result(result)


def figures(result: Any, what: Any = None, **how: Any) -> dict[str, Picture]:
    """Draw pictures as new figures by name; default: of maps, distributions, spectra and curves
    what the result has, maps only with a window, and of several results the curves.
    """
    if isinstance(result, list):
        return {name: plot(result, name, **how) for name in what or ["curves"]}
    result = _result(result)
    if not result.steps:
        raise SceneError(f"{result.path}: no finished load step yet, nothing to draw")
    possible = (
        ["maps"]
        if how.get("window")
        else [name for name in PAGES if chosen_steps(result, name, how.get("step"))]
    )
    if len(result.steps) == 1 and len(possible) > 1:
        possible = [name for name in possible if name != "curves"]
    wanted = [what] if isinstance(what, str) else what or possible
    return {name: plot(result, name, **how) for name in wanted}


def plot_result(file: Any, where: Any = None, what: Any = None, **how: Any) -> list[Path]:
    """Draw `figures`, save them and return their paths. where: a folder, made if its parent
    exists, or a file, with names appended for several; default: RESULT.png beside the result.
    """
    if not isinstance(file, list):
        file = _result(file)
        where = where or (file.path or Path("contact")).with_suffix(".png")
    drawn = figures(file, what, **how)
    several = len(drawn) > 1
    return [
        _save_picture(fig, Path(where or "curves.png"), name, several, how.get("dpi"))
        for name, fig in drawn.items()
    ]


def _save_picture(fig: Picture, where: Path, name: str, several: bool, dpi: float | None) -> Path:
    """Save a picture as `where` (.png, .pdf or .svg), or as NAME.png in the folder `where`."""
    as_file = where.suffix.lower() in SUFFIXES and not where.is_dir()
    folder = where.parent if as_file else where
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise SceneError(f"-o: pictures cannot go to {folder} ({reason(error)})") from None
    path = folder / f"{name}.png"
    if as_file:
        path = where.with_stem(f"{where.stem}_{name}") if several else where
    try:
        save(fig, path, dpi)
    except OSError as error:
        raise GfmdError(f"writing {path}: {reason(error)}") from error
    return path


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
    if kind.page is curves or len(able) <= MAX_STEPS:
        return able
    return [able[k] for k in np.linspace(0, len(able) - 1, MAX_STEPS).round().astype(int)]


def _steps(result: Result, panels: Mapping[str, tuple[str, ...]]) -> list[int]:
    """Return the indices of the load steps that have a number or field of any of the panels."""
    keys = {key for needed in panels.values() for key in needed}
    return [
        k
        for k, (step, fields) in enumerate(zip(result.steps, result.fields))
        if any(
            key in fields or good(step.get(key)) or np.ndim(step.get(key, 0)) or is_tight(key, step)
            for key in keys
        )
    ]


def _name(result: Result) -> str:
    """Return the title of the result's scene, or the name of its file, or "contact"."""
    title = ""
    with suppress(tomllib.TOMLDecodeError):
        title = tomllib.loads(result.scene_toml).get("title", "")
    return title or (result.path.stem if result.path else "contact")


def _title(view: View, what: str) -> str:
    """Return the title of a figure: title and surface of the result, number of loads left out."""
    left = view.left_out if what != "heights" else 0
    out = f"; {left} of {left + len(view.result.steps)} loads not shown" if left else ""
    return title_of(_name(view.result), view.result.surface) + out
