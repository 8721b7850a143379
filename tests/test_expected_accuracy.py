"""What error to expect on unseen poses, found without measuring any."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.identification import CalibrationResult
from elastocal.identification.expected import MOST_ROWS, some_poses
from elastocal.identification.statistics import Statistics
from elastocal.measurements import Measurements, repeats
from elastocal.robot import Compliance
from support.calibrations import measured
from support.files import Desk, desk, save_simulated
from support.robots import arm, placed
from support.transitions import SPRINGS

__all__ = ["desk"]

SEED = 4
"""Of an arm with a step of which poses change sides when they are left out."""


def bent(law: str, seed: int) -> ec.Robot:
    """An arm anywhere whose joint 2 follows a law."""
    low, torque = SPRINGS["2"]
    springs = {"rigid": {}, "linear": {"2.theta": Compliance("linear", low[:1])}}
    elastic = springs.get(law, {"2.theta": Compliance(law, low, torque)})
    return replace(placed(arm(), np.random.default_rng(seed)), elastic=elastic)


def calibrated(law: str, data: Measurements, **options: object) -> CalibrationResult:
    """The calibration with the law that the arm has."""
    return ec.calibrate(arm(), data, elastic={} if law == "rigid" else {"2": law}, **options)


def by_refits(law: str, data: Measurements) -> Statistics:
    """The errors of all poses under calibrations without them, one for each pose."""
    return ec.cross_validate(lambda rows: calibrated(law, rows).robot, data, len(np.unique(repeats(data))))


@pytest.mark.parametrize(("law", "close"), [("rigid", 1e-4), ("linear", 1e-4), ("hinge", 0.03), ("step", 1e-4)])
def test_it_is_the_error_of_fits_without_each_pose(law: str, close: float):
    data = measured(bent(law, SEED), 30, SEED, noise=3e-5)
    found, refits = calibrated(law, data).residuals, by_refits(law, data)
    assert found["cross_validated"].n == 30
    for figure in ("mean", "rms", "max"):
        assert getattr(found["cross_validated"], figure) == pytest.approx(getattr(refits, figure), rel=close)
    assert found["cross_validated"].mean > 1.1 * found["calibrated"].mean


def test_a_torque_in_the_middle_of_its_gap_is_not_known_without_the_poses_at_its_edges():
    data = measured(bent("step", SEED), 36, SEED, noise=3e-5)
    searched = calibrated("step", data)
    given = calibrated("step", data, transition=[searched.elastic[0].transition_torque])
    assert searched.residuals["cross_validated"].max > 2.0 * given.residuals["cross_validated"].max


def test_repeats_are_left_out_together():
    actual = bent("linear", 1)
    q = np.repeat(ec.random_poses(actual, 20, 1), 3, axis=0)
    data = ec.simulate(actual, q, noise=3e-5)
    alone = replace(data, q=q + 0.01 * np.arange(len(q))[:, None] % 0.03)  # apart, so that they are poses of their own
    together, apart = (calibrated("linear", rows).residuals["cross_validated"].rms for rows in (data, alone))
    assert together == pytest.approx(by_refits("linear", data).rms, rel=2e-3)
    assert together != pytest.approx(apart, rel=0.01)


def test_positions_and_orientations_both_have_it():
    actual = placed(arm(), np.random.default_rng(2))
    data = measured(actual, 16, 2, kinds=("position", "orientation"), noise=3e-5, noise_angle=1e-4)
    found, refits = ec.calibrate(arm(), data).residuals["cross_validated"], by_refits("rigid", data)
    assert found.mean == pytest.approx(refits.mean, rel=0.01)
    assert found.angle.mean == pytest.approx(refits.angle.mean, rel=0.01)


def test_on_average_it_is_the_error_of_other_poses():
    ratios = []
    for seed in range(12):
        actual = bent("linear", seed)
        result = calibrated("linear", measured(actual, 30, seed, noise=3e-5))
        unseen = ec.validate(result.robot, measured(actual, 300, seed + 100, noise=3e-5)).statistics
        ratios.append(result.residuals["cross_validated"].rms / unseen.rms)
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.1)


def test_rows_held_out_take_its_place():
    data = measured(bent("rigid", 1), 60, 1, noise=3e-5)
    assert "cross_validated" not in ec.calibrate(arm(), data, holdout=0.3).residuals
    assert "cross_validated" not in ec.calibrate(arm(), data.take(np.arange(40)), held_out=data).residuals


def test_there_is_none_where_a_pose_decides_a_parameter_alone():
    data = measured(bent("rigid", 1), 9, 1, noise=3e-5)  # 27 coordinates for 27 parameters
    result = ec.calibrate(arm(), data)
    assert "cross_validated" not in result.residuals
    assert any("hold rows out" in note for note in result.notes)


def test_few_of_many_poses_are_chosen_whole():
    rng = np.random.default_rng(0)
    q = np.repeat(rng.uniform(-3.0, 3.0, (4000, 6)), 2, axis=0)
    numbered = np.where(np.arange(8000) < 4000, np.arange(8000) // 2 % 200, -1)
    for data in (Measurements(q), Measurements(q, pose=numbered)):
        rows = some_poses(data, 1000)
        assert 1000 <= len(rows) < 1200
        assert (np.diff(rows) > 0).all()
    chosen = np.zeros(8000, dtype=bool)
    chosen[some_poses(Measurements(q), 1000)] = True
    np.testing.assert_array_equal(chosen[::2], chosen[1::2])
    chosen[:] = False
    chosen[some_poses(Measurements(q, pose=numbered), 1000)] = True
    whole = [set(np.flatnonzero(numbered == pose)) <= set(np.flatnonzero(chosen)) for pose in numbered[chosen][:50]]
    assert all(whole)
    assert len(some_poses(Measurements(q), 8000)) == 8000


def test_of_very_many_rows_some_are_judged():
    data = measured(bent("rigid", 1), MOST_ROWS + 1000, 1, noise=3e-5)
    found = ec.calibrate(arm(), data).residuals
    assert found["cross_validated"].n == MOST_ROWS
    assert found["cross_validated"].mean == pytest.approx(found["calibrated"].mean, rel=0.03)


def test_the_command_says_it_as_what_to_expect(desk: Desk):
    save_simulated(desk.folder)
    out = desk.done("calibrate robot.toml fit.csv --elastic 2,3")
    assert "expected, unseen poses" in out
    result = json.loads(desk.done("calibrate robot.toml fit.csv --elastic 2,3 --json"))
    figures = {name: f"{1e3 * result['residuals'][name]['mean']:.3g} mm" for name in ("cross_validated", "calibrated")}
    assert f"{figures['cross_validated']} mean" in result["verdict"]
    assert f"(the fit's residual is {figures['calibrated']})" in result["verdict"]
