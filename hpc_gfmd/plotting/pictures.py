"""All pictures of a result: which there are, and how they are drawn and saved."""

import tomllib
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from ..output.read import read_result
from ..output.result import Result
from ..output.summary import surface_line
from ..scene.explain import nearest
from ..util.errors import GfmdError, SceneError, reason
from .context import FigureContext
from .curves import curves, is_tight
from .distributions import NAMES, distributions
from .maps import FIELDS, maps
from .page import COLUMN_WIDTH, Page
from .quantities import OVERVIEW, QUANTITIES
from .spectra import PANELS, spectra
from .style import Picture, legend, new_picture, save, styled
from .units import good

MAX_STEPS = 4  # in maps, distributions and spectra unless `step` is given
SUFFIXES = (".png", ".pdf", ".svg")


@dataclass(frozen=True)
class Kind:
    """A kind of pictures.

    Attributes
    ----------
    page : callable
        Makes a Page from figure contexts and names of panels.
    panels : dict of str to tuple of str
        Names of numbers and fields, by panel. A load step is shown in a panel if it has one of
        them.
    over_loads : bool
        Whether the picture shows curves against the load: then all loads, and several results, are
        drawn together.
    """

    page: Callable[[list[FigureContext], list[str]], Page]
    panels: Mapping[str, tuple[str, ...]]
    over_loads: bool = False


def _curve(name: str) -> Kind:
    """Make the kind of picture that is one curve, of the number `name`, against the load."""
    return Kind(curves, {name: (name,)}, over_loads=True)


MAPS = {name: (name,) for name in FIELDS} | {"contact": ("pressure", "gap")}
PAGES = {
    "maps": Kind(maps, {name: MAPS[name] for name in ("contact", "pressure", "gap")}),
    "distributions": Kind(
        distributions, {name: (*MAPS.get(name, ()), f"{name}_edges") for name in NAMES}
    ),
    "spectra": Kind(spectra, {name: (f"{name}_q", f"{name}_r") for name in PANELS}),
    "curves": Kind(curves, {name: (name,) for name in OVERVIEW}, over_loads=True),
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
) -> Picture:
    """Draw one picture of a result, or the curves of several.

    Parameters
    ----------
    result : Solutions, Solution or path, or several
        Solved loads, or the path of a result file. Several, as a list or as a dict with names for
        the legend, can only be drawn as curves.
    what : str, optional
        "maps" (pressure and gap), or a single map: "pressure", "gap", "contact", "heights",
        "displacement", "plastic"; "distributions"; "spectra"; "curves" against the load, or a
        single curve: "a_r", "kappa", "gap_mean", "approach", or any other number of the loads, such
        as "conductance" or "critical_gap_x". Default: the first that the result has of maps,
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
        raise SceneError("result: found none, allowed: a result or several")
    if what is None:
        what = next((name for name in PICTURES if _can_draw(name, results, step)), "maps")
    if not _can_draw(what, results, step):
        _refuse(what, results, step)
    with styled():
        contexts = [
            FigureContext(one, chosen_steps(one, what, step), window, dpi, dimensionless, name)
            for name, one in results.items()
        ]
        kind = kind_of(what)
        drawn = [
            name
            for name, keys in kind.panels.items()
            if any(_steps(context.result, {name: keys}) for context in contexts)
        ]
        if "pressure" in drawn and what == "maps":
            drawn.remove("contact")  # which the pressure shows, too
        page = kind.page(contexts, drawn)
        if columns is not None:
            page = page.with_columns(columns)
        fig = ax.figure if ax else new_picture()
        try:
            if ax is None:
                page.draw(fig)
                narrow = fig.get_figwidth() <= COLUMN_WIDTH
                legend(fig, "outside lower center", columns=1 if narrow else 4)
                if len(contexts) == 1:
                    fig.suptitle(_title(contexts[0], what), x=0.01, ha="left", wrap=True)
            elif len(page.panels) == 1:
                page.panels[0](ax)
            else:
                raise SceneError(
                    f"ax: found {what!r} of {len(page.panels)} panels, allowed: one panel, such as"
                    ' "pressure" of one load, or "a_r"'
                )
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise GfmdError(f"drawing {contexts[0].result.path}: {reason(error)}") from error
    return fig


def _can_draw(what: Any, results: Mapping[str, Result], step: Any) -> bool:
    """Whether every result has a load step for the picture `what`; of several, only curves.

    False if `what` is not a text. Raises SceneError if step names load steps that a result does not
    have.
    """
    if not isinstance(what, str) or not (len(results) == 1 or kind_of(what).over_loads):
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
    hint = f'nearest: "{nearest(what, PICTURES)}", ' if is_misspelt else ""
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
    """Draw several pictures of a result, each as a new figure.

    Parameters
    ----------
    result : Solutions, Solution or path
    what : str or list of str, optional
        Names of pictures. Default: of maps, distributions, spectra and curves those that the result
        has; with a window maps only; curves of a single load only if there is nothing else.
    **how
        As for `plot`.

    Returns
    -------
    dict of str to Picture
        By the names of the pictures.

    Raises
    ------
    SceneError, GfmdError
        As `plot`, and if the result has no finished load step.
    """
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
    """Draw pictures of a result and save them; existing files are replaced.

    Parameters
    ----------
    file : path or Result
    where : path, optional
        A folder, created if its parent exists, or a file .png, .pdf or .svg (if there are several
        pictures each gets its name appended). Default: RESULT.png beside the result,
        RESULT_NAME.png if there are several; contact.png in the working directory if the result is
        in memory.
    what : str or list of str, optional
        As for `figures`.
    **how
        As for `plot`.

    Returns
    -------
    list of Path
        Paths of the pictures.

    Raises
    ------
    SceneError, GfmdError
        As `figures` and `save_picture`.
    """
    result = _result(file)
    where = Path(where or (result.path or Path("contact")).with_suffix(".png"))
    drawn = figures(result, what, **how)
    several = len(drawn) > 1
    return [save_picture(fig, where, name, several, how.get("dpi")) for name, fig in drawn.items()]


def save_picture(
    fig: Picture, where: Path, name: str, several: bool = False, dpi: float | None = None
) -> Path:
    """Save a picture in a folder, or as a file, which is replaced if it exists.

    Parameters
    ----------
    fig : Picture
    where : Path
        A folder, created if its parent exists, or a file .png, .pdf or .svg.
    name : str
        Name of the picture. In a folder the file is name.png.
    several : bool
        Whether to append _name to the name of the file `where`.
    dpi : float, optional
        Default: print resolution.

    Returns
    -------
    Path
        Path of the picture.

    Raises
    ------
    SceneError
        If the folder cannot be made.
    GfmdError
        If the picture cannot be written.
    """
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
    """Choose the load steps that a picture shows.

    Parameters
    ----------
    result : Result
    what : str
        Name of the picture.
    step : int, sequence of int or None
        Numbers of load steps. None: all that the picture can show for curves, the first of them for
        "heights", otherwise at most four.

    Returns
    -------
    list of int
        Indices in result.steps; those that lack what the picture shows are left out.

    Raises
    ------
    SceneError
        If step is empty or names load steps that the result does not have.
    """
    kind = kind_of(what)
    able = _steps(result, kind.panels)
    if step is not None:
        if not np.size(step):
            raise SceneError("step: found none, allowed: the number of a load step or several")
        return [k for k in result.places(np.atleast_1d(step).tolist()) if k in able]
    if what == "heights":
        return able[:1]  # the same under all loads
    if kind.over_loads or len(able) <= MAX_STEPS:
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


def _title(context: FigureContext, what: str) -> str:
    """Return the title of a figure: title and surface of the result, number of loads left out."""
    left = context.left_out if what != "heights" else 0
    out = f"; {left} of {left + len(context.result.steps)} loads not shown" if left else ""
    line = surface_line(
        {key: context.result.surface.get(key) for key in ("n", "physical_sizes", "h_rms", "unit")}
    )
    for plain, printed in ((" x ", " × "), (" um", " µm"), ("h_rms", r"$h_\mathrm{rms}$")):
        line = line.replace(plain, printed)
    return f"{_name(context.result)}: {line}{out}"
