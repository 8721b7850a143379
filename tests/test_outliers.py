"""Outliers: all of them found, hardly any good row accused, and the fit what it is without them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.identification import CalibrationResult, calibrate
from elastocal.measurements import Labels, Measurements, concatenate
from elastocal.robot import Frame, Payload, Robot
from elastocal.simulation import random_poses, simulate
from support.outliers import NOISE, as_built, laws, spoiled
from support.robots import arm

POINTS = {"a": (0.1, 0.0, 0.0), "b": (0.0, 0.1, 0.02), "c": (-0.08, 0.0, 0.05)}


def measured(actual: Robot, count: int, seed: int, **options: object) -> Measurements:
    options = {"noise": NOISE, "noise_angle": 1e-4, **options}
    return simulate(actual, random_poses(actual, count, seed), seed=seed, **options)


def named(result: CalibrationResult) -> list[int]:
    return sorted(outlier.index for outlier in result.outliers)


def values(result: CalibrationResult) -> list[float]:
    return [parameter.identified for parameter in result.parameters]


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("law", ["rigid", "linear", "hinge", "step"])
def test_the_fit_is_that_of_the_good_rows(law: str, seed: int):
    data, wrong = spoiled(measured(as_built(seed, law), 60, seed), seed)
    result = calibrate(arm(), data, elastic=laws(law), loss="cauchy")
    assert named(result) == wrong.tolist()
    assert all(outlier.rejected for outlier in result.outliers)
    good = calibrate(arm(), data.take(np.setdiff1d(np.arange(60), wrong)), elastic=laws(law))
    np.testing.assert_allclose(values(result), values(good), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(result.covariance, good.covariance, rtol=1e-6)
    assert result.nominal_robot == good.nominal_robot


def test_hubers_loss_finds_them_too():
    data, wrong = spoiled(measured(as_built(4), 60, 4), 4)
    assert named(calibrate(arm(), data, elastic=laws("linear"), loss="huber")) == wrong.tolist()


def test_statistics_are_of_all_rows():
    data, _ = spoiled(measured(as_built(5), 60, 5), 5)
    result = calibrate(arm(), data, elastic=laws("linear"), loss="cauchy")
    found = result.residuals["calibrated"]
    assert found.n == 60
    assert found.max == pytest.approx(max(outlier.residual for outlier in result.outliers), rel=1e-6)
    assert result.coordinates == 3 * 54
    assert min(outlier.residual for outlier in result.outliers) > 4e-3
    assert np.median(result.errors.calibrated.norms) < 1e-4


def test_with_the_linear_loss_outliers_are_named_and_fitted():
    data, wrong = spoiled(measured(as_built(6), 60, 6), 6)
    data = replace(data, source=Labels.of(["day 1.csv"] * 40 + ["day 2.csv"] * 20), row=np.r_[1:41, 1:21])
    result = calibrate(arm(), data, elastic=laws("linear"))
    assert set(named(result)) <= set(wrong.tolist())
    assert not any(outlier.rejected for outlier in result.outliers)
    worst = result.outliers[0]
    assert (worst.file, worst.row) == ("day 1.csv" if worst.index < 40 else "day 2.csv", worst.index % 40 + 1)
    warning = next(warning for warning in result.warnings if "--loss cauchy" in warning)
    assert f"{worst.file} row" in warning
    assert str(worst.row) in warning
    everything = calibrate(arm(), data, elastic=laws("linear"), loss="linear")
    assert values(everything) == values(result)


@pytest.mark.parametrize(("loss", "sets"), [("linear", 30), ("cauchy", 12)])
def test_good_rows_are_hardly_ever_accused(loss: str, sets: int):
    """One data set in a hundred has one by the rule."""
    accused = [
        len(calibrate(arm(), measured(as_built(seed), 40, seed), elastic=laws("linear"), loss=loss).outliers)
        for seed in range(sets)
    ]
    assert sum(accused) <= 0.1 * sets


@pytest.mark.parametrize("law", ["hinge", "step"])
def test_rows_that_only_the_final_laws_explain_are_not_accused(law: str):
    """Few rows beyond a transition torque are outliers to linear laws."""
    for seed in range(2):
        data = measured(as_built(seed, law), 60, seed)
        assert len(calibrate(arm(), data, elastic=laws(law), loss="cauchy").outliers) <= 1


def test_outliers_of_a_tenth_of_a_millimetre_are_found_where_noise_is_a_hundredth():
    data, wrong = spoiled(measured(as_built(7), 80, 7, noise=1e-5), 7, smallest=2e-4, largest=5e-4)
    assert named(calibrate(arm(), data, elastic=laws("linear"), loss="cauchy")) == wrong.tolist()


def test_data_without_noise_have_no_outliers():
    result = calibrate(arm(), measured(as_built(8), 60, 8, noise=0.0, noise_angle=0.0), elastic=laws("linear"))
    assert result.outliers == ()


def test_each_row_is_judged_by_its_own_standard_deviation():
    """A reading 0.3 mm off is an outlier of a good instrument, and none of a poor one."""
    actual = as_built(9)
    fine, coarse = (measured(actual, 60, i, noise=size, state_sigma=True) for i, size in enumerate((1e-5, 3e-4)))
    data = concatenate([fine, coarse])
    position = data.position.copy()
    position[[5, 70]] += 3e-4 / np.sqrt(3.0)
    result = calibrate(arm(), replace(data, position=position), elastic=laws("linear"), loss="cauchy")
    assert named(result) == [5]


def test_one_of_several_readings_of_a_pose_is_left_out_alone():
    actual = as_built(10)
    q = np.repeat(random_poses(actual, 40, 10), 3, axis=0)
    data, wrong = spoiled(simulate(actual, q, noise=NOISE, seed=1), 10)
    assert named(calibrate(arm(), data, elastic=laws("linear"), loss="cauchy")) == wrong.tolist()


@pytest.mark.parametrize("kind", ["orientation", "distance"])
def test_other_kinds_of_observation_have_outliers_too(kind: str):
    kinds = ("position", "orientation") if kind == "orientation" else ("distance",)
    data = measured(as_built(11, "rigid"), 100, 11, kinds=kinds)
    observed = getattr(data, kind).copy()
    wrong = [3, 50, 77]
    observed[wrong] = observed[[4, 51, 78]] if kind == "orientation" else observed[wrong] + 10e-3
    result = calibrate(arm(), replace(data, **{kind: observed}), loss="cauchy")
    assert named(result) == wrong
    assert {outlier.kind for outlier in result.outliers} == {kind}


def with_setups(robot: Robot, known: bool) -> Robot:
    """The robot with three targets, two payloads and two stations."""
    targets = {name: Frame(xyz, known=True) for name, xyz in POINTS.items()}
    places = {
        "north": Frame((1.0, 0.5, 0.2), (0.1, 0.2, 2.0), True),
        "south": Frame((-2.0, 0.3, 0.0), (0.0, 0.1, 1), True),
    }
    stations = places if known else dict.fromkeys(places, Frame())
    loads = {"heavy": Payload(20.0, (0.0, 0.0, 0.1)), "light": Payload(2.0)}
    return replace(robot, targets=targets, stations=stations, loads=loads)


def test_several_targets_payloads_and_stations():
    actual, nominal = with_setups(as_built(12), known=True), with_setups(arm(), known=False)
    setups = zip("abcabc", ["north", "south"] * 3, ["heavy", "light", "light"] * 2, strict=True)
    parts = [measured(actual, 20, i, target=t, station=s, load=m) for i, (t, s, m) in enumerate(setups)]
    data, wrong = spoiled(concatenate(parts), 12)
    assert named(calibrate(nominal, data, elastic=laws("linear"), loss="cauchy")) == wrong.tolist()


@pytest.mark.parametrize("loss", ["linear", "cauchy"])
def test_a_wrong_target_name_in_a_row_is_told_with_the_right_one(loss: str):
    actual, nominal = with_setups(as_built(13), known=True), with_setups(arm(), known=True)
    data = concatenate([measured(actual, 25, i, target=name, station="north") for i, name in enumerate(POINTS)])
    codes = data.target.codes.copy()
    codes[[4, 30]] = 2
    data = replace(data, target=replace(data.target, codes=codes))
    result = calibrate(nominal, data, elastic=laws("linear"), loss=loss)
    assert {outlier.index: outlier.hint for outlier in result.outliers} == {4: "target 'a'", 30: "target 'b'"}
    assert "row 5 fits target 'a', not the one named there: correct the target's name" in result.warnings


@pytest.mark.parametrize("share", [0.45, 0.55])
def test_where_half_of_the_rows_are_wrong_it_is_said_that_something_is(share: float):
    data, _ = spoiled(measured(as_built(14), 60, 14), 14, share=share)
    result = calibrate(arm(), data, elastic=laws("linear"), loss="cauchy")
    assert sum(outlier.rejected for outlier in result.outliers) <= 24
    said = "more than can be told from good ones", "robot and data do not belong together"
    assert any(words in warning for warning in result.warnings for words in said)


def test_compliances_are_kept_from_becoming_negative_without_outliers_too():
    data, wrong = spoiled(measured(as_built(15, "rigid"), 60, 15), 15)
    result = calibrate(arm(), data, elastic=laws("linear"), loss="cauchy", non_negative=True)
    assert named(result) == wrong.tolist()


def test_joint_maps_are_identified_from_the_good_rows():
    data, wrong = spoiled(measured(as_built(16, "rigid"), 100, 16), 16)
    result = calibrate(arm(), data, loss="cauchy", transmission=3)
    assert named(result) == wrong.tolist()


def test_held_out_rows_are_not_looked_for_outliers():
    data, wrong = spoiled(measured(as_built(17), 100, 17), 17)
    result = calibrate(arm(), data, elastic=laws("linear"), loss="cauchy", holdout=0.4)
    assert result.residuals["held_out"].n == 40
    assert max(named(result)) < 60
    bad = np.isin(result.errors.data.position, data.position[wrong]).all(axis=1) & ~result.errors.held_out
    assert named(result) == np.flatnonzero(bad).tolist()
