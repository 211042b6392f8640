"""Calibrated numbers are found where they stand, and the campaign says what they have to be."""

from contextlib import contextmanager
from dataclasses import dataclass, field

import pytest
from campaign import calibrate, run

from hpc_gfmd.certificate import certificate, error_estimates


@dataclass(frozen=True)
class SomeCalibration:
    share: float = 0.5
    derived: float = field(default=2.0, metadata={"measured": "by hand"})


def test_numbers_are_found_and_put_back(monkeypatch):
    """Wherever a module of the package has the instance; those measured otherwise are not."""
    some = SomeCalibration()
    for module in (certificate, error_estimates):
        monkeypatch.setattr(module, "SOME", some, raising=False)
    found = calibrate.numbers()
    assert "test_calibrate.derived" not in found
    value, change = found["test_calibrate.share"]
    with change(0.25):
        assert certificate.SOME == error_estimates.SOME == SomeCalibration(0.25)
    assert value == 0.5
    assert certificate.SOME is error_estimates.SOME is some


def test_a_number_is_moved_until_loads_fail(monkeypatch):
    """A stand-in for the campaign: loads fail below 0.4, and cost what the number is."""
    now = [1.0]

    def campaign(given):
        row = {"status": "converged", "kkt": 0.0, "accuracy": 9.0, "true": [0.4] * 3}
        yield [row | {"claimed": [now[-1]] * 3, "fft_pairs": 10 * now[-1]}]

    @contextmanager
    def change(value):
        now.append(value)
        yield
        now.pop()

    monkeypatch.setattr(calibrate, "campaign", campaign)
    found = calibrate.refit(None, 1.0, change, calibrate.outcome(None))
    assert 0.4 <= found["smallest"] < 0.46
    assert found["pairs_smallest"] == pytest.approx(10 * found["smallest"], rel=1e-2)
    assert (found["largest"], found["pairs_largest"]) == (None, 80)


def test_numbers_are_moved_in_this_process_alone():
    given = run.parser().parse_args(["calibrate", "--jobs", "2"])
    with pytest.raises(SystemExit, match="--jobs: found 2, allowed: 1"):
        calibrate.calibrate(given)


def test_every_family_belongs_to_one_group():
    grouped = run.names(["single", "free", "sweeps", "targets"])
    assert sorted(grouped) == sorted(run.names(["all"]))
