"""Calibrated numbers are found in the package, and the campaign determines their limits."""

from contextlib import contextmanager
from dataclasses import dataclass, field

import pytest
from campaign import calibrate, run

from hpc_gfmd.certificate import certificate, error_estimates


@dataclass(frozen=True)
class SomeCalibration:
    share: float = 0.5
    derived: float = field(default=2.0, metadata={"measured": "by hand"})


def test_numbers_are_found_and_restored(monkeypatch):
    """In all modules with the instance, except numbers that are measured otherwise."""
    calibration = SomeCalibration()
    for module in (certificate, error_estimates):
        monkeypatch.setattr(module, "SOME", calibration, raising=False)
    numbers = calibrate.numbers()
    assert "test_calibrate.derived" not in numbers
    value, change = numbers["test_calibrate.share"]
    with change(0.25):
        assert certificate.SOME == error_estimates.SOME == SomeCalibration(0.25)
    assert value == 0.5
    assert certificate.SOME is error_estimates.SOME is calibration


def test_a_number_is_moved_until_loads_fail(monkeypatch):
    """In this stand-in for the campaign loads fail below 0.4 and cost 10 times the number."""
    values = [1.0]

    def campaign(args):
        row = {"status": "converged", "kkt": 0.0, "accuracy": 9.0, "true": [0.4] * 3}
        yield [row | {"claimed": [values[-1]] * 3, "fft_pairs": 10 * values[-1]}]

    @contextmanager
    def change(value):
        values.append(value)
        yield
        values.pop()

    monkeypatch.setattr(calibrate, "campaign", campaign)
    limits = calibrate.refit(None, 1.0, change, calibrate.outcome(None))
    assert 0.4 <= limits["smallest"] < 0.46
    assert limits["pairs_smallest"] == pytest.approx(10 * limits["smallest"], rel=1e-2)
    assert limits["largest"] is None
    assert limits["pairs_largest"] == 80


def test_calibration_needs_one_process():
    args = run.make_parser().parse_args(["calibrate", "--jobs", "2"])
    with pytest.raises(SystemExit, match="--jobs: found 2, allowed: 1"):
        calibrate.calibrate(args)


def test_every_family_belongs_to_one_group():
    grouped = run.names(["single", "free", "sweeps", "targets"])
    assert sorted(grouped) == sorted(run.names(["all"]))
