"""Pictures are made, show something, and say what is doubtful; statistics behind them are right."""

from argparse import Namespace

import matplotlib.image
import numpy as np
import pytest

from hpc_gfmd.commands import plot
from hpc_gfmd.errors import GfmdError, SceneError
from hpc_gfmd.output.record import RunFile
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.plotting import plot_result, style, survey


@pytest.fixture(autouse=True)
def _coarse_pictures(monkeypatch):
    monkeypatch.setitem(style.RC, "savefig.dpi", 60)


SCENE = '[surface]\nkind = "self-affine"\nhurst = 0.8\n'


def write(path, n=(32, 24), steps=2, fields=("pressure", "gap"), surface=None, status="converged", **attributes):
    random = np.random.default_rng(1)
    surface = {"n": list(n), "physical_sizes": [1.0, 0.75], "h_rms": 0.1, "g_rms": 1.0, "eps_f": 0.01} | (surface or {})
    with RunFile(SerialComm(), path, n, (0, n[0]), {"scene": SCENE, "identity": "a"}, surface) as run:
        for index in range(steps):
            noise = random.normal(size=n)
            whole = {"pressure": np.maximum(noise, 0), "gap": np.maximum(-noise, 0)}
            p = 0.01 * 4.0**index
            step = {"p": p, "p_star": p, "a_r": 0.5, "kappa": 0.5 / p, "gap_mean": 0.4, "gap_over_h_rms": 4.0}
            step |= {"a_r_error": 1e-3, "status": status} | attributes
            run.write_step(index, step, {name: whole[name] for name in fields})
        run.finish(status)
    return path


def ink(path):
    """Share of the pixels that are not white."""
    image = matplotlib.image.imread(path)[..., :3]
    return float((image.min(axis=-1) < 0.99).mean())


def test_three_pictures_lie_beside_the_file(tmp_path):
    made = plot_result(write(tmp_path / "run.h5"))
    assert [p.name for p in made] == ["run_contact_maps.png", "run_distributions.png", "run_curves.png"]
    assert all(p.parent == tmp_path and ink(p) > 0.02 for p in made)
    assert sorted(p.name for p in tmp_path.iterdir() if p.suffix != ".h5") == sorted(p.name for p in made)


def test_pictures_in_a_new_folder(tmp_path, capsys):
    file = write(tmp_path / "run.h5", status="stagnated")
    assert plot.main(Namespace(file=str(file), output=str(tmp_path / "a" / "b"))) == 0
    made = sorted(p.name for p in (tmp_path / "a" / "b").iterdir())
    assert made == ["contact_maps.png", "curves.png", "distributions.png"]
    assert "! not converged: step 0, 1 (marked in the pictures)" in capsys.readouterr().out


@pytest.mark.parametrize("fields", [("pressure",), ("gap",), ()])
def test_whatever_fields_there_are(tmp_path, fields):
    made = plot_result(write(tmp_path / "run.h5", fields=fields))
    assert len(made) == (3 if fields else 1)
    assert all(ink(p) > 0.01 for p in made)


@pytest.mark.parametrize(
    ("surface", "attributes"),
    [
        ({"h_rms": 0.0, "g_rms": 0.0, "eps_f": 0.0}, {"p_star": float("inf"), "gap_over_h_rms": float("nan")}),
        ({}, {"a_r": 1.0, "gap_mean": 0.0, "gap_over_h_rms": 0.0}),
        ({}, {"a_r_error": float("inf"), "gap_error": float("nan")}),
        ({"eps_f": float("nan")}, {"a_r": None, "kappa": None}),
    ],
    ids=["flat", "full contact", "unknown errors", "few observables"],
)
def test_unusual_results_are_drawn_too(tmp_path, surface, attributes):
    assert len(plot_result(write(tmp_path / "run.h5", surface=surface, **attributes))) == 3


def test_many_steps_and_long_cells(tmp_path):
    file = write(tmp_path / "run.h5", n=(3, 50), steps=9, surface={"physical_sizes": [0.1, 2.0]})
    assert len(plot_result(file)) == 3


def test_nothing_to_draw_or_nowhere_to_put_it(tmp_path):
    with pytest.raises(SceneError, match="nothing to draw"):
        plot_result(write(tmp_path / "empty.h5", steps=0))
    (tmp_path / "file").write_text("")
    with pytest.raises(SceneError, match="pictures cannot go there"):
        plot_result(write(tmp_path / "run.h5"), tmp_path / "file")


def test_damaged_fields_are_an_error_in_one_line(tmp_path, monkeypatch):
    file = write(tmp_path / "run.h5", steps=1, fields=("gap",))

    def transfer(*_):
        raise OSError("bad chunk")

    monkeypatch.setattr("hpc_gfmd.parallel.h5._transfer", transfer)
    with pytest.raises(GfmdError, match=r"reading .*run\.h5: bad chunk"):
        plot_result(file)


class Whole:
    """A field in memory that looks like a stored one and remembers how much was read at once."""

    def __init__(self, values):
        self.values, self.shape, self.most = values, values.shape, 0

    def pieces(self, at_once):
        self.most = at_once
        return [(i, self.values[i : i + at_once]) for i in range(0, len(self.values), at_once)]


def test_survey_reads_slabs_and_keeps_means(monkeypatch):
    monkeypatch.setattr(survey, "MAX_PIXELS", 16)
    monkeypatch.setattr(survey, "SLAB_BYTES", 8 * 47 * 10)
    noise = np.random.default_rng(2).normal(size=(101, 47))
    pressure, gap = Whole(np.maximum(noise, 0)), Whole(np.maximum(-noise, 0))
    found = survey.survey({"pressure": pressure, "gap": gap}, 2.0, 4.0)
    assert pressure.most <= 10
    assert found.contact.shape == (15, 16)
    assert found.contact[0, 0] == (noise[:7, :3] > 0).mean()
    assert found.pressure[-1, -1] == pytest.approx(np.maximum(noise[98:, 45:], 0).mean() / 2)
    assert found.gap[3, 5] == pytest.approx(np.maximum(-noise[21:28, 15:18], 0).mean() / 4)


def test_densities_integrate_to_the_areas(monkeypatch):
    noise = np.random.default_rng(2).normal(size=(200, 200)) - 1
    found = survey.survey({"pressure": Whole(np.maximum(noise, 0)), "gap": Whole(np.maximum(-noise, 0))}, 1.0, 1.0)
    contact = (noise > 0).mean()
    ratio = 10 ** (1 / survey.PER_DECADE)
    for (x, density), share in ((found.pressure_density, contact), (found.gap_density, 1 - contact)):
        widths = x * (ratio**0.5 - ratio**-0.5)
        assert (density * widths).sum() == pytest.approx(share, rel=1e-12)
