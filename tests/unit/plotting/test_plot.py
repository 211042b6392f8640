"""Plots: files, units, statistics, theory curves and notes agree with the results drawn."""

import re
import tomllib
from functools import cache
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from contacts import rough_wall, scene_text
from refusal import refused
from result_files import begin

import hpc_gfmd
from hpc_gfmd import make_surface, plot
from hpc_gfmd.commands.plot import figures, save_pictures
from hpc_gfmd.output.read import read_result
from hpc_gfmd.output.summary import error_bars
from hpc_gfmd.plotting import maps, style


@pytest.fixture(autouse=True)
def _low_resolution(monkeypatch):
    monkeypatch.setitem(style.RC, "savefig.dpi", 60)


LOAD = "[load]\np_star = [0.1]\n"
SCENE = scene_text((1, 16, 2), [0.1])
SPHERE = '[surface]\nkind = "sphere"\nradius = 1.0\nn = [32, 24]\n' + LOAD
WAVE = '[surface]\nkind = "wave"\namplitude = 0.1\nn = [32, 24]\nperiods = [0, 2]\n' + LOAD
UNITS = {"unit": "m", "pressure_unit": "Pa", "physical_sizes": [1e-5, 7.5e-6], "h_rms": 2e-8}


def write(
    path,
    n=(32, 24),
    steps=2,
    fields=("pressure", "gap"),
    surface=None,
    status="converged",
    scene=SCENE,
    spike=1.0,
    **attributes,
):
    """Write a result file of random fields.

    spike: factor of the largest pressure; attributes: replace numbers of every step.
    """
    random = np.random.default_rng(1)
    surface = {
        "n": list(n),
        "physical_sizes": [1.0, 0.75],
        "h_rms": 0.1,
        "g_rms": 1.0,
        "eps_f": 0.01,
    } | (surface or {})
    with begin(path, surface=surface, head={"scene": scene}) as run:
        for index in range(steps):
            noise = random.normal(size=n)
            whole = {"pressure": np.clip(noise, 0, 1.5), "gap": np.maximum(-noise, 0)}
            whole["pressure"].flat[whole["pressure"].argmax()] *= spike
            p = 0.01 * 4.0**index
            step = {
                "p": p,
                "p_star": p,
                "a_r": 0.5,
                "kappa": 0.5 / p,
                "gap_mean": 0.4,
                "gap_over_h_rms": 4.0,
                "a_r_error": 1e-3,
                "status": status,
            } | attributes
            run.write_step(index, step, {name: whole[name] for name in fields})
        run.finish(status)
    return path


def ink(path):
    """Fraction of pixels that are not white."""
    image = matplotlib.image.imread(path)[..., :3]
    return float((image.min(axis=-1) < 0.99).mean())


def test_files_of_pictures(tmp_path, cli):
    """Beside the result, in a new folder, or in a file whose suffix selects the format."""
    file = write("run.h5", status="stagnated")
    made = save_pictures([read_result(file)], names=["pressure", "a_r"])
    assert [str(path) for path in made] == ["run_pressure.png", "run_a_r.png"]
    assert all(ink(path) > 0.02 for path in made)
    assert "not converged: step 0, 1" in cli.prints("plot", file, "-o", "a", "--what", "a_r")
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["a_r.png"]
    (tmp_path / "file").write_text("")
    for place in ("no/b", "file"):
        assert "pictures cannot go to" in cli.refused("plot", file, "-o", place)
    assert ".png, .pdf, .svg" in cli.refused("plot", file, "-o", "a.jpg")
    for suffix, begins in (("pdf", b"%PDF"), ("svg", b"<?xml")):
        (path,) = save_pictures([read_result(file)], Path(f"one.{suffix}"), ["contact"], step=1)
        assert path.read_bytes().startswith(begins)
        assert path.name == f"one.{suffix}"
    several = save_pictures([read_result(file)], Path("all.png"), ["a_r", "kappa"])
    assert [path.name for path in several] == ["all_a_r.png", "all_kappa.png"]


UNUSUAL = tomllib.loads("""
flat = {surface = {h_rms = 0.0, g_rms = 0.0, eps_f = 0.0}, p_star = inf, gap_over_h_rms = nan}
full_contact = {a_r = 1.0, gap_mean = 0.0, gap_over_h_rms = 0.0}
unknown_errors = {a_r_error = inf, gap_error = nan}
long_cell = {surface = {physical_sizes = [0.1, 2.0]}, n = [3, 50]}
gap_alone = {fields = ["gap"]}
no_field = {fields = [], patches = 7}
tiny_share = {fields = ["gap"], pressure_edges = [0.0, 1.0, 2.0], pressure_density = [1.0, 1e-20]}
""") | {"few_numbers": {"surface": {"eps_f": float("nan")}, "a_r": None, "kappa": None}}


@pytest.mark.parametrize("name", UNUSUAL)
def test_unusual_results_are_drawn(name):
    drawn = figures([read_result(write("run.h5", **UNUSUAL[name]))])
    assert list(drawn) == (
        ["curves"] if name == "no_field" else ["maps", "distributions", "curves"]
    )
    for fig in drawn.values():
        assert any(ax.lines or ax.images or ax.patches for ax in fig.axes)


@cache
def solved(kind, units):
    """Solutions of two loads on 64 x 64 points, in um and MPa or without units."""
    L, heights, E_star = ("20 um", "0.2 um", "2 GPa") if units else (1.0, 0.01, 1.0)
    options = {"p_star": [0.02, 0.2], "E_star": E_star}
    if kind == "wave":
        wall = make_surface(kind, n=(64, 64), physical_sizes=(L, L), amplitude=heights)
    elif kind == "sphere":
        wall = make_surface(kind, n=(64, 64), physical_sizes=(L, L), radius=L, boundary="free")
    else:
        wall = rough_wall(physical_sizes=(L, L))
    if kind == "layer":
        options |= {"thickness": "2 um" if units else 0.1, "nu": 0.3}
    return hpc_gfmd.solve(wall, **options)


def unit_of(label, solution):
    """The unit in an axis label, as a multiple of the solution's unit."""
    surface = solution.result.surface
    absolute = {"nm": 1e-9, "µm": 1e-6, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}
    match = re.search(r" \(([^$()]+)(?:\$\^\{(\d)\}\$)?\)$", label)
    if match:
        return absolute[match[1]] ** int(match[2] or 1)
    modulus = solution.p / solution.p_star / surface["g_rms"]
    relative = {
        "L_x": surface["physical_sizes"][0],
        r"h_\mathrmrms": surface["h_rms"],
        r"E^*g_\mathrmrms": modulus * surface["g_rms"],
        "E^*": modulus,
        "A": surface["h_rms"] * np.sqrt(2),  # the amplitude of a wave
    }
    return relative[re.sub(r"[(){}$ ]", "", label.partition("/")[2])] if "/" in label else 1.0


def assert_readable(fig):
    """Require that tick labels do not overlap and that all data lie within their axes."""
    fig.canvas.draw()
    for ax in fig.axes:
        for axis, along in ((ax.xaxis, "x"), (ax.yaxis, "y")):
            boxes = [
                tick.label1.get_window_extent()
                for tick in axis.get_major_ticks()
                if tick.label1.get_text()
                and tick.label1.get_visible()
                and min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())
            ]
            ends = sorted((getattr(box, f"{along}0"), getattr(box, f"{along}1")) for box in boxes)
            assert all(low < high for (_, low), (high, _) in zip(ends, ends[1:])), ax.get_title()
        for bar in ax.containers:
            x, y = bar.lines[0].get_xydata().T
            (x0, x1) = ax.get_xlim()
            y0, y1 = ax.get_ylim()
            assert ((x0 < x) & (x < x1) & (y0 <= y) & (y < 0.98 * y1)).all()


@pytest.mark.parametrize(("kind", "units"), [("rough", True), ("wave", False), ("sphere", False)])
def test_plots_show_the_computed_numbers(kind, units):
    solutions = solved(kind, units)
    fig = solutions.plot("maps")
    images = [image for ax in fig.axes for image in ax.get_images()]
    for solution, shown in zip(solutions, (images[:2], images[2:])):
        size = solution.result.surface["physical_sizes"]
        pressure, gap = (np.ma.filled(one.get_array(), 0).T for one in shown)
        assert (~np.ma.getmaskarray(shown[0].get_array()).T == solution.contact).all()
        for image, field, exact in zip(shown, (pressure, gap), (solution.pressure, solution.gap)):
            unit = unit_of(image.colorbar.ax.get_ylabel(), solution)
            assert field * unit == pytest.approx(exact, rel=1e-6)
            bar = image.colorbar
            top = exact.max() / unit
            clipped = bar.extend == "max"
            words = "square root" if field is gap else f"max {top:.3g}" if clipped else ""
            assert bar.ax.get_title("left") == words
            assert clipped or image.norm.vmax == pytest.approx(top)
        length = unit_of(fig.axes[-1].get_xlabel(), solution)
        assert np.array(image.get_extent()[1::2]) * length == pytest.approx(size)

    fig = solutions.plot("curves")
    assert_readable(fig)
    drawn = {ax.get_ylabel(): ax.containers[0].lines[0].get_xydata().T for ax in fig.axes}
    for label, (x, y) in drawn.items():
        name = next(n for symbol, n in SYMBOLS.items() if symbol in label)
        p_unit = unit_of(fig.axes[0].get_xlabel().replace("p^* = ", ""), solutions[0])
        assert x * p_unit == pytest.approx(solutions.values("p"))
        unit = unit_of(label, solutions[0]) if name in ("gap_mean", "approach") else 1.0
        assert y * unit == pytest.approx(solutions.values(name))

    for stored in (False, True):
        for solution in solutions if stored else ():
            solution.distribution("pressure")
            solution.distribution("gap")
            solution.result.steps[0].pop("a_r", None)
        fig = solutions.plot("distributions")
        for ax, name in zip(fig.axes, ("pressure", "gap")):
            unit = unit_of(ax.get_xlabel(), solutions[0])
            for solution, stairs in zip(solutions, ax.patches, strict=True):
                field = getattr(solution, name)[solution.contact == (name == "pressure")]
                values, edges, _ = stairs.get_data()
                share = field.size / solution.gap.size
                assert (values * np.diff(edges)).sum() == pytest.approx(
                    share, rel=0.02 if stored else 1e-9
                )
                assert edges[0] * unit <= field.min() * (1 + 1e-6)
                assert edges[-1] * unit == pytest.approx(field.max(), rel=0.2 if stored else 1e-6)
                assert ax.get_xlim()[0] < np.median(field) / unit < edges[-1] <= ax.get_xlim()[1]
                y0, y1 = ax.get_ylim()
                assert y0 < values.min() <= values.max() < y1


SYMBOLS = {"a_r$": "a_r", "kappa": "kappa", "langle": "gap_mean", "delta": "approach"}


def test_a_closed_gap_has_no_autocorrelation():
    closed = hpc_gfmd.solve(np.eye(8), a_r=1.0)
    closed.distribution("gap_autocorrelation")
    with np.errstate(all="raise"):
        assert not plot(closed, "spectra").axes[0].get_lines()[1:]  # except for the axis


@pytest.mark.parametrize("kind", ["wave", "rough"])
def test_plot_of_spectra(kind):
    """The spectrum of a wave is a single point."""
    solution = solved(kind, units=True)[0]
    spectrum = solution.distribution("heights_spectrum")
    solution.distribution("pressure_autocorrelation")
    with refused("what: found 'spectra' of step 1, allowed: maps"):
        solved(kind, units=True).plot("spectra", step=1)
    ax = figures([solution.result])["spectra"].axes[0]
    assert_readable(ax.figure)
    assert "A_p(r)/A_p(0)" in text_of(ax.figure)
    (line,) = ax.get_lines()
    q, power = line.get_data()
    assert q == pytest.approx(
        spectrum["q"][spectrum["power"] > 1e-12 * spectrum["power"].max()] * 1e-6
    )
    if kind == "wave":
        assert ax.get_ylabel() == "$C_z(q)$ (nm$^{2}$ µm$^{2}$)"
        assert power == pytest.approx([200**2 * 20**2 / 4])
        assert line.get_marker() == "."


def test_units_of_plots():
    solutions = solved("rough", units=True)
    assert "20 × 20 µm" in text_of(solutions.plot("maps"))
    for kind, relative in (("maps", "/{L_x}"), ("curves", "p^* ="), ("distributions", "/(E^* g")):
        fig = solutions.plot(kind, dimensionless=True)
        assert relative in text_of(fig)
        assert not [ax for ax in fig.axes if re.search("[µM]", ax.get_xlabel() + ax.get_ylabel())]


def test_plots_on_given_axes():
    solutions = solved("rough", units=True)
    left, right = matplotlib.figure.Figure().subplots(1, 2)
    assert solutions[1].plot("pressure", ax=left) is left.figure
    assert left.get_images()[0].get_array().count() == solutions[1].contact.sum()
    wave = solved("wave", units=False)
    hpc_gfmd.plot(wave, "kappa", ax=right)  # not among the curves of a wave
    assert right.containers[0].lines[0].get_ydata() == pytest.approx(wave.values("kappa"))
    with refused("ax: 'maps' has 4 panels"):
        solutions.plot("maps", ax=left)


def test_several_results_in_one_plot():
    soft = solved("rough", units=True)
    hard = solved("layer", units=True)
    for results, names in (({"soft": soft, "hard": hard}, "soft hard"), ([soft, hard], "1: 2:")):
        fig = hpc_gfmd.plot(results, "curves")
        legend = [text.get_text() for text in fig.legends[0].get_texts()]
        assert all(any(label.startswith(name) for label in legend) for name in names.split())
        ax = next(ax for ax in fig.axes if "langle" in ax.get_ylabel())
        for bars, solutions in zip(ax.containers, (soft, hard), strict=True):
            y = bars.lines[0].get_ydata() * unit_of(ax.get_ylabel(), solutions[0])
            assert y == pytest.approx(solutions.values("gap_mean"))
    with refused("what: found 'maps', allowed: curves"):
        hpc_gfmd.plot([soft, hard], "maps")
    with refused("results: have different units"):
        hpc_gfmd.plot([soft, solved("rough", units=False)], "a_r")


class ReadField:
    """An array with the interface of a stored field that records the largest read."""

    def __init__(self, values):
        self.values = values
        self.shape = values.shape
        self.largest_read = 0

    def read(self, start, stop):
        self.largest_read = max(self.largest_read, stop - start)
        return self.values[start:stop]


def text_of(fig):
    texts = " | ".join(artist.get_text() for artist in fig.findobj(matplotlib.text.Text))
    return texts.replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.parametrize(
    ("scene", "kind", "name"),
    [
        (SCENE, "self-affine", "Persson"),
        (SPHERE, "sphere", "Hertz"),
        (WAVE, "wave", "Westergaard"),
        ("", "file", None),
    ],
)
def test_theory_is_only_drawn_for_its_surfaces(scene, kind, name):
    file = write("run.h5", scene=scene, surface={"kind": kind})
    for picture in figures([read_result(file)], ["curves", "distributions"]).values():
        text = text_of(picture)
        assert {theory for theory in ("Persson", "Hertz", "Westergaard") if theory in text} == (
            {name} if name else set()
        )
    assert r"\kappa" in text_of(plot(file, "curves")) or kind in ("sphere", "wave")
    layer = scene.replace("[load]", "[material]\nnu1 = 0.3\nthickness = 0.1\n[load]")
    assert not name or name not in text_of(
        plot(write("layer.h5", scene=layer, surface={"kind": kind}), "curves")
    )


def test_tight_loads_are_shaded():
    """Where no channel is open a logarithmic axis has nothing to show, and the picture says it."""
    wall = rough_wall()
    sweep = hpc_gfmd.solve(
        wall, p_star=[0.01, 0.1, 0.2, 0.6, 1.0], observables=["critical_gap"], fields=()
    )
    gaps = sweep.values("critical_gap_x")
    first = int(np.argmax(gaps == 0))
    assert first > 1
    (ax,) = sweep.plot("critical_gap_x").axes
    (shaded,) = (patch for patch in ax.patches if patch.get_label() == "tight")
    assert shaded.get_x() == pytest.approx(sweep.p_star[first])
    assert ax.get_xlim()[1] > sweep.p_star[-1]
    assert len(ax.containers[0].lines[0].get_xdata()) == first
    (ax,) = sweep.plot("critical_gap_x", step=[0, 1]).axes
    assert not ax.patches
    only_tight = hpc_gfmd.solve(wall, p_star=[0.8, 1.0], observables=["critical_gap"], fields=())
    for results in ([only_tight], [only_tight] * 7):
        (ax,) = hpc_gfmd.plot(results, "critical_gap_x").axes
        assert ax.patches[0].get_label() == "tight"
        assert ax.get_xlim()[0] < 0.8 < 1.0 < ax.get_xlim()[1]


def test_windows_show_all_grid_points():
    file = write("run.h5", surface=UNITS)
    for window in ((2.5e-6, 5e-6, 0, 2.5e-6), ("2.5um", "5 um", "0", "2500nm")):
        (image,) = plot(file, "gap", step=1, window=window).axes[0].get_images()
        assert np.allclose(image.get_extent(), (2.5, 5, 0, 2.5))
        gap = read_result(file).fields[1]["gap"].read(0, 32)[8:16, :8]  # up to 3 m
        assert np.allclose(np.ma.filled(image.get_array(), 0), gap.T)
    for wrong in ((0, 1, 0, 1), (3e-6, 1e-6, 0, 1e-6), ("a", 1, 0, 1), (0, 1e-6, 0)):
        with refused(r"^window: found .*, allowed: x0 x1 y0 y1 with 0 <= x0 < x1 <= 1e-05 m"):
            plot(file, window=wrong)


def test_missing_results_and_steps_are_refused():
    with refused("nothing to draw"):
        save_pictures([read_result(write("empty.h5", steps=0))])
    with refused("result: an empty list"):
        hpc_gfmd.plot([])
    file = write("run.h5", n=(8, 6), fields=())
    for options, words in (
        ({"what": "map"}, 'what: found .map., nearest: "maps", allowed: curves'),
        ({"what": "maps"}, "need output.fields"),
        ({"what": "curves", "step": 7}, "step: found 7, allowed: 0, 1"),
        ({"what": "curves", "step": []}, "step: an empty list"),
        ({"what": "curves", "step": 0.5}, r"step: found 0\.5, allowed: 0, 1"),
    ):
        with refused(words):
            plot(file, **options)


def test_a_mistake_while_drawing_is_raised_as_it_is(monkeypatch):
    monkeypatch.setattr(maps, "reduce_fields", None)
    with pytest.raises(TypeError, match="not callable"):
        plot(write("run.h5", n=(8, 6)), "maps")


def test_heights_of_an_array():
    heights = np.random.default_rng(1).normal(size=(30, 20)) * 1e-8
    scan = hpc_gfmd.prepare_surface(heights, physical_sizes=(3e-6, 2e-6), unit="m", boundary="free")
    fig = scan.plot(title="a scan")
    assert all(
        words in text_of(fig) for words in ("a scan: 30 × 20 points", "$z$ (nm)", "$x$ (µm)")
    )
    assert fig._repr_png_().startswith(b"\x89PNG")
    surface = make_surface("wave", amplitude="20 nm", n=[16, 8], physical_sizes=["2 um", "1 um"])
    assert "$z$ (nm)" in text_of(surface.plot())


def test_survey_reads_slabs_and_keeps_means(monkeypatch):
    monkeypatch.setattr(maps, "SLAB_BYTES", 8 * 47 * 10)
    noise = np.random.default_rng(2).normal(size=(101, 47))
    pressure = ReadField(np.maximum(noise, 0))
    gap = ReadField(np.maximum(-noise, 0))
    surveyed = maps.reduce_fields({"pressure": pressure, "gap": gap}, 16)
    assert pressure.largest_read <= 10
    assert surveyed.means["contact"].shape == (15, 16)
    assert surveyed.means["contact"][0, 0] == (noise[:7, :3] > 0).mean()
    block = noise[98:, 45:]
    assert surveyed.means["pressure"][-1, -1] == pytest.approx(block[block > 0].mean())
    assert surveyed.means["gap"][3, 5] == pytest.approx(np.maximum(-noise[21:28, 15:18], 0).mean())
    assert surveyed.largest["pressure"] == noise.max()


def rough_sweep(seed=1, **arguments):
    """Solutions of three loads on a small wall, with units."""
    wall = rough_wall((1, 8, 2), seed=seed, physical_sizes=("10 um", "10 um"), h_rms="20 nm")
    loads = [f"{p} MPa" for p in (30, 100, 300)]
    return hpc_gfmd.solve(wall, loads, "110 GPa", **arguments)


UNITS_OF_CURVES = {  # per um, nm, none, GPa, none, none
    "conductance": 1e6,
    "critical_gap_x": 1e-9,
    "patches": 1.0,
    "contact_pressure_max": 1e9,
    "gap_percolates_x": 1.0,
    "fft_pairs": 1.0,
}


def test_curves_of_any_observable():
    sweep = rough_sweep(observables=["conductance", "critical_gap", "patches", "percolation"])
    for name, unit in UNITS_OF_CURVES.items():
        (ax,) = sweep.plot(name).axes
        line, _, _ = ax.containers[0].lines
        np.testing.assert_allclose(line.get_ydata(), sweep.values(name) / unit)


def test_bars_are_those_of_the_table():
    """On the side where the error of the area is known to be; the corrected area has its own."""
    sweep = rough_sweep()
    (ax,) = sweep.plot("a_r").axes
    for bars, name in zip(ax.containers, ("a_r", "a_r_corrected"), strict=True):
        (lines,) = bars.lines[2]
        for value, step, ends in zip(sweep.values(name), sweep.steps, lines.get_segments()):
            below, above = error_bars(name, step)
            np.testing.assert_allclose(ends[:, 1], [value * (1 - below), value * (1 + above)])
            assert (above < 0.9 * below) == (name == "a_r")


def test_many_results_are_drawn_as_mean_and_scatter():
    sweeps = [rough_sweep(seed, fields=()) for seed in range(8)]
    fig = hpc_gfmd.plot(sweeps, "a_r")
    (ax,) = fig.axes
    areas = np.array([sweep.a_r for sweep in sweeps])
    (mean,) = (line for line in ax.lines if "mean of 8" in line.get_label())
    np.testing.assert_allclose(mean.get_ydata(), areas.mean(axis=0))
    (band,) = ax.collections
    edges = band.get_paths()[0].vertices
    at_first = edges[np.isclose(edges[:, 0], mean.get_xdata()[0]), 1]
    spread = areas[:, 0].std(ddof=1)
    assert at_first.max() - at_first.min() == pytest.approx(2 * spread)
    assert len(fig.legends[0].get_texts()) <= 3


@pytest.mark.parametrize("number", [2, 7])
def test_each_result_is_divided_by_its_own_roughness(number):
    walls = [rough_wall((2, 8, 2), seed=seed, g_rms=0.1 * (seed + 1)) for seed in range(number)]
    sweeps = [hpc_gfmd.solve(wall, p_star=[0.02, 0.1], fields=()) for wall in walls]
    (ax,) = hpc_gfmd.plot(sweeps, "gap_mean").axes
    gaps = np.array([sweep.values("gap_over_h_rms") for sweep in sweeps])
    if number == 2:
        for bars, own in zip(ax.containers, gaps, strict=True):
            np.testing.assert_allclose(bars.lines[0].get_xydata(), np.stack([[0.02, 0.1], own], 1))
    else:
        (mean,) = (line for line in ax.lines if "mean of 7" in line.get_label())
        np.testing.assert_allclose(mean.get_xydata(), np.stack([[0.02, 0.1], gaps.mean(axis=0)], 1))


def test_force_axis():
    z = -np.add.outer(np.linspace(-1, 1, 24) ** 2, np.linspace(-1, 1, 24) ** 2) * 1e-6
    ball = hpc_gfmd.prepare_surface(z, physical_sizes=("20 um", "20 um"), unit="m", boundary="free")
    sweep = hpc_gfmd.solve(ball, force=["1 mN", "2 mN"], E_star="100 GPa")
    (ax,) = sweep.plot("a_r").axes
    assert ax.get_xlabel() == "force $F$ (mN)"
    np.testing.assert_allclose(ax.lines[0].get_xdata(), [1, 2])
    (ax,) = sweep.plot("a_r", dimensionless=True).axes  # a force has no scale without its unit
    assert ax.get_xlabel().startswith("pressure")


def test_maps_mark_yielding_points():
    """Also of an array, which has no scene."""
    solution = hpc_gfmd.solve(rough_wall().heights, p_star=0.1, hardness=0.5, boundary="periodic")
    yielded = solution.pressure >= 0.99999 * 0.5
    assert yielded.any()
    ax, *_ = solution.plot("pressure").axes
    mark = ax.images[-1].get_array()
    np.testing.assert_array_equal(~np.ma.getmaskarray(mark).T, yielded)
    assert ax.get_legend_handles_labels()[1][-1].startswith("yields")


def test_a_loop_of_approach_and_retraction_with_its_pull_off():
    """Lines of both branches over loads of both signs; the pull-off is marked."""
    loads = {"approach": [0.0, 0.1, 0.3], "retraction": [0.3, 0.1, 0.0, -0.005, -0.5]}
    wall = rough_wall((2, 4, 4), g_rms=1.0, physical_sizes=(8.0, 8.0))
    adhesion = {"work": np.pi * 0.01, "range": 0.1}
    sweeps = {
        name: hpc_gfmd.solve(wall, pressures, adhesion=adhesion, branch=name, fields=())
        for name, pressures in loads.items()
    }
    assert sweeps["retraction"][-1].status == "separated"
    (ax,) = hpc_gfmd.plot(sweeps, "a_r").axes
    for name, bars in zip(sweeps, ax.containers, strict=True):
        held = [solution for solution in sweeps[name] if solution.status == "converged"]
        line = bars.lines[0]
        assert bars.get_label() == name
        assert line.get_linestyle() == "-"
        np.testing.assert_allclose(line.get_xdata(), [solution.p for solution in held])
        np.testing.assert_allclose(line.get_ydata(), [solution.a_r for solution in held])
    (mark,) = (line for line in ax.lines if line.get_label() == "pull-off")
    np.testing.assert_allclose(mark.get_xdata(), sweeps["retraction"].pull_off)
    assert sweeps["retraction"].pull_off == -0.005
    assert ax.get_xscale() == "linear"
    assert ax.get_xlim()[0] < -0.005
