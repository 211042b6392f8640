"""Maps of contact, pressure, gap and other fields, of the whole cell or of a window."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import ListedColormap, Normalize, PowerNorm

from ..output.fields import Slab
from ..output.result import Result
from ..output.summary import converged, is_positive, surface_line
from ..util.errors import SceneError, one_line
from ..util.quantities import parse
from .style import (
    CONTACT_MAP,
    DPI,
    GROUND,
    PRESSURE_MAP,
    WARNING,
    WIDTH,
    YIELDED,
    Page,
    Picture,
    Scale,
    Units,
    load_label,
)

FIELDS = {  # symbol, colours
    "contact": ("", CONTACT_MAP),
    "pressure": ("p", PRESSURE_MAP),
    "gap": ("g", "viridis"),
    "heights": ("z", "cividis"),
    "displacement": ("u", "viridis"),
    "plastic": ("d", "viridis"),
    "dent": ("w", "viridis"),
}
# a largest value that is more than this times the 99.5th percentile does not set the colours
SPIKY = 1.25
SLAB_BYTES = 2**25
YIELD_ROUNDING = 1e-5  # relative, of a pressure that is the hardness, in single precision


class Window(NamedTuple):
    """A part of the cell: its edges (x0, x1, y0, y1), at those of grid points, and its points (i0,
    i1, j0, j1), None for all.
    """

    edges: tuple[float, ...]
    points: tuple[int, ...] | None


def window_of(surface: Any, window: Any) -> Window:
    """Return the part of a cell in a window, such as (0, "2 um", 0, 1e-6), or all without one."""
    sizes = np.array(surface.get("physical_sizes", (1.0, 1.0)))
    n = np.array(surface["n"])
    if window is None:
        return Window((0.0, sizes[0], 0.0, sizes[1]), None)
    try:
        low, high = np.reshape([_length(edge) for edge in window], (2, 2)).T
        inside = np.all((0 <= low) & (low < high) & (high <= sizes * (1 + 1e-9)))
    except (TypeError, ValueError):
        inside = np.False_
    if not inside:
        text = " ".join(map(str, window)) if isinstance(window, list | tuple) else str(window)
        L_x, L_y = (f"{size:g} {surface.get('unit', '')}".rstrip() for size in sizes)
        raise SceneError(
            f"window: found {one_line(text)}, allowed: x0 x1 y0 y1 with 0 <= x0 < x1 <= {L_x} and"
            f' 0 <= y0 < y1 <= {L_y}, plain or as "2um"'
        )
    start = np.minimum((low / sizes * n + 1e-9).astype(int), n - 1)
    stop = np.clip(np.ceil(high / sizes * n - 1e-9).astype(int), start + 1, n)
    points = np.transpose([start, stop])
    edges = (points * (sizes / n)[:, None]).ravel()
    return Window(tuple(edges), tuple(points.ravel().tolist()))


def _length(edge: Any) -> float:
    """Return a length, a number or a text such as "5 um", as a number; units become m."""
    try:
        return float(edge)
    except ValueError:
        return float(parse(edge, "length"))


def maps(
    result: Result, names: list[str], units: Units, window: Window, dpi: float | None = None
) -> Page:
    """Return a page with a row for each load and a column for each field, read when drawn."""
    loads = range(len(result.steps))
    columns = min(2, len(loads)) if len(names) == 1 else len(names)
    pixels = _pixels(columns, dpi)

    @cache
    def reduced(k: int) -> Reduced:
        fields = result.fields[k]
        alone = {*names} <= {"heights", "displacement", "plastic", "dent"}
        needed = {*names} if alone else {*names, "pressure", "gap"}
        chosen = {n: fields[n] for n in needed & {*fields}}
        return reduce_fields(chosen, pixels, window.points, hardness_of(result))

    def panel(k: int, name: str, ax: Any) -> None:
        _field(ax, name, reduced(k), units, window)
        if name != names[0]:
            ax.set_title(name if k == 0 else "", loc="right")
        elif name != "heights":
            step = result.steps[k]
            start = "\n" if _aspect(window) >= 2 else ", "
            area = f"{start}$a_r = {step['a_r']:.3g}$" if is_positive(step.get("a_r")) else ""
            colour = "black" if converged(step) else WARNING
            ax.set_title(load_label(result, k, units) + area, loc="left", color=colour)

    return _page([partial(panel, k, name) for k in loads for name in names], columns, window)


def hardness_of(result: Result) -> float | None:
    """Return the hardness of the material of a result; None without one, or without a scene."""
    scene = result.readable_scene
    return scene.material.hardness if scene else None


def height_map(
    heights: Any,
    surface: Mapping[str, Any],
    title: str = "surface",
    window: Any = None,
    dpi: float | None = None,
) -> Picture:
    """Draw a map of heights (n_x, n_y), peaks up, of a surface with attributes as in a result."""
    window = window_of(surface, window)
    field = Slab(heights, 0, heights.shape)
    pixels = reduce_fields({"heights": field}, _pixels(1, dpi), window.points)
    panel = partial(_field, name="heights", pixels=pixels, units=Units(surface), window=window)
    return _page([panel], 1, window).picture(title_of(title, surface))


def title_of(name: str, surface: Mapping[str, Any]) -> str:
    """Return the title of a figure: a name, and points, sizes and roughness of the surface."""
    line = surface_line({k: surface.get(k) for k in ("n", "physical_sizes", "h_rms", "unit")})
    for plain, printed in ((" x ", " × "), (" um", " µm"), ("h_rms", r"$h_\mathrm{rms}$")):
        line = line.replace(plain, printed)
    unbroken = line.replace(" ", "\N{NO-BREAK SPACE}").replace(",\N{NO-BREAK SPACE}", ", ")
    return f"{name}: {unbroken}"


def _aspect(window: Window) -> float:
    x0, x1, y0, y1 = window.edges
    return (y1 - y0) / (x1 - x0)


def _width(columns: int) -> float:
    return 0.735 * WIDTH / max(columns, 2)


def _pixels(columns: int, dpi: float | None) -> int:
    return max(16, int(_width(columns) * (dpi or DPI)))


def _page(panels: Sequence[Callable[[Any], None]], columns: int, window: Window) -> Page:
    height = _width(columns) * np.clip(_aspect(window), 0.4, 2.4) + 0.34
    return Page(panels, columns, height, WIDTH if columns > 1 else WIDTH / 2, images=True)


def _mark_yielded(ax: Any, share: np.ndarray, extent: list[float]) -> None:
    """Colour the pixels in which at least half of the touching points yield."""
    yielded = np.ma.masked_less(share, 0.5)
    if yielded.count():
        ax.imshow(
            yielded.T,
            ListedColormap([YIELDED]),
            origin="lower",
            extent=extent,
            interpolation="nearest",
        )
        _explain(ax, YIELDED, "yields (pressure = hardness)")


def _explain(ax: Any, colour: str, text: str) -> None:
    """Add a legend entry for a colour that no colour bar has."""
    ax.plot([], [], "s", color=colour, markeredgecolor="0.6", label=text)


def _field(ax: Any, name: str, pixels: "Reduced", units: Units, window: Window) -> None:
    """Draw one of the fields of a load on axes, with its colour bar (none for contact)."""
    symbol, colours = FIELDS[name]
    in_units = [pixels.largest[name], float(pixels.means[name].min())]
    scale = units.of(name, in_units) if symbol else Scale()
    values = pixels.means[name] / scale.unit
    largest = pixels.largest[name] / scale.unit
    clipped = False
    norm: Any = Normalize(values.min(), values.max())
    if name == "contact":
        values = np.ma.masked_equal(values, 0)
        norm = Normalize(0, 1)
        _explain(ax, "white", "contact: white where the gap is open")
    elif name == "pressure":
        ax.set_facecolor(GROUND)
        values = np.ma.masked_where(pixels.means["contact"] == 0, values)
        top = np.percentile(values.compressed(), 99.5) if values.count() else 1.0
        clipped = largest > SPIKY * top > 0
        norm = Normalize(0, top if clipped else largest)
        _explain(ax, GROUND, "pressure: grey where the gap is open")
    elif name == "gap":  # square root: most of what matters happens at small gaps
        values = np.ma.masked_where(pixels.means["contact"] >= 0.5, values)
        norm = PowerNorm(0.5, vmin=0, vmax=largest)
        _explain(ax, "white", "gap: white where it touches")
    if norm.vmin == norm.vmax:
        norm.vmax += 1
    x0, x1, y0, y1 = window.edges
    lengths = units.of("length", [x1 - x0, y1 - y0])
    extent = [edge / lengths.unit for edge in window.edges]
    image = ax.imshow(
        values.T, colours, norm, origin="lower", extent=extent, interpolation="nearest"
    )
    if name in ("contact", "pressure") and "yielded" in pixels.means:
        _mark_yielded(ax, pixels.means["yielded"], extent)
    ax.tick_params(color="0.5")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter("{x:g}")
    ax.set(xlabel=lengths.label("x"), ylabel=lengths.label("y"))
    if name == "contact":
        return
    titled = clipped or isinstance(norm, PowerNorm)
    bar = ax.figure.colorbar(
        image,
        cax=ax.inset_axes([1.04, 0, 0.06, 0.95 if titled else 1]),
        extend="max" if clipped else "neither",
    )
    bar.set_label(scale.label(symbol))
    if isinstance(norm, PowerNorm):
        bar.ax.set_title("square root", fontsize=6.5, pad=2, loc="left")
    if clipped:
        bar.ax.set_title(f"max {largest:.3g}", fontsize=6.5, pad=2, loc="left")


class Reduced(NamedTuple):
    """Fields of a load step, reduced to pixels: `means` over points, of pressure over those that
    touch (else 0); shares "contact" and "yielded"; `largest` value of a point, by field.
    """

    means: dict[str, np.ndarray]
    largest: dict[str, float]


def reduce_fields(
    fields: dict, pixels: int, window: tuple | None = None, hardness: float | None = None
) -> Reduced:
    """Reduce fields of a step to at most `pixels` along each axis, a few rows at a time."""
    shape = next(iter(fields.values())).shape
    i0, i1, j0, j1 = window or (0, shape[0], 0, shape[1])
    f_x, f_y = (max(1, -(-n // pixels)) for n in (i1 - i0, j1 - j0))
    parts: dict[str, list] = {}
    largest: dict[str, float] = {}
    for slab in slabs(fields, i0, i1, f_x, slice(j0, j1)):
        if hardness is not None and "pressure" in slab:
            slab["yielded"] = slab["pressure"] >= hardness * (1 - YIELD_ROUNDING)
        for name, values in slab.items():
            in_contact = name in ("pressure", "yielded")
            counted = slab["contact"] if in_contact else np.ones(values.shape)
            values = values * counted
            total = _pixel_sums(values, f_x, f_y)
            points = _pixel_sums(counted, f_x, f_y)
            parts.setdefault(name, []).append(total / np.maximum(points, 1))
            largest[name] = max(largest.get(name, -np.inf), float(values.max()))
    return Reduced({name: np.concatenate(blocks) for name, blocks in parts.items()}, largest)


def slabs(fields: dict, i0: int, i1: int, multiple: int, columns: slice) -> Iterator[Any]:
    """Yield {field: rows, float64} slab by slab, with a multiple of `multiple` rows but the last;
    "contact" is added.
    """
    shape = next(iter(fields.values())).shape
    rows = max(1, SLAB_BYTES // (8 * shape[1]) // multiple) * multiple
    for start in range(i0, i1, rows):
        stop = min(start + rows, i1)
        slab: dict[str, np.ndarray] = {
            name: np.asarray(field.read(start, stop), dtype=np.float64)[:, columns]
            for name, field in fields.items()
        }
        if "gap" in slab:
            slab["contact"] = slab["gap"] <= 0
        elif "pressure" in slab:
            slab["contact"] = slab["pressure"] > 0
        yield slab


def _pixel_sums(values: Any, f_x: int, f_y: int) -> np.ndarray:
    """Return sums over blocks of f_x times f_y points; the last blocks may be smaller."""
    sums = np.add.reduceat(values.astype(np.float64), np.arange(0, values.shape[0], f_x), axis=0)
    return np.add.reduceat(sums, np.arange(0, values.shape[1], f_y), axis=1)
