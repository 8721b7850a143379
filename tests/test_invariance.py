"""Laws of a calibration: what must not change its outcome."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.chain import rotation_from_rpy
from elastocal.identification import calibrate
from elastocal.prediction import predict
from elastocal.simulation import random_poses
from support.calibrations import ALL_LINEAR, actual_in_gauge, gauge_of, measured
from support.robots import arm

KINDS = ("position", "orientation")


def example(elastic: bool = False, count: int = 60, seed: int = 0):
    gauge = gauge_of(arm(), KINDS, ALL_LINEAR if elastic else {})
    actual = actual_in_gauge(arm(), gauge, np.random.default_rng(seed))
    return actual, measured(actual, count, seed, kinds=KINDS, noise=3e-5, noise_angle=3e-5)


def links(result) -> dict[str, float]:
    """Identified link parameters and compliances by name."""
    return {p.name: p.identified for p in result.parameters if p.name[0].isdigit()}


def test_moving_the_instrument_changes_no_link_parameter():
    _, data = example(elastic=True)
    turn, shift = rotation_from_rpy((0.4, -1.1, 2.0)), np.array([3.0, -2.0, 1.0])
    moved = replace(data, position=data.position @ turn.T + shift, orientation=turn @ data.orientation)
    before, after = (calibrate(arm(), d, elastic=ALL_LINEAR) for d in (data, moved))
    assert links(after) == pytest.approx(links(before), abs=1e-9)
    assert after.robot.base.rotation == pytest.approx(turn @ before.robot.base.rotation, abs=1e-9)


def test_the_order_of_the_poses_changes_nothing():
    _, data = example(elastic=True)
    shuffled = data.take(np.random.default_rng(0).permutation(len(data)))
    assert links(calibrate(arm(), shuffled, elastic=ALL_LINEAR)) == pytest.approx(
        links(calibrate(arm(), data, elastic=ALL_LINEAR)), abs=1e-10
    )


def test_the_choice_among_dependent_parameters_changes_no_prediction_of_a_rigid_robot():
    """Keeping 3.d instead of 2.d, or 1.theta instead of the base's turn, says the same in other words."""
    actual, data = example()
    free = calibrate(arm(), data)
    other = calibrate(arm(), data, fix=["2.d", "base.rz"])
    assert {"3.d", "1.theta"} <= set(other.gauge.kept)
    q = random_poses(actual, 100, 5)
    assert predict(other.robot, q)[0] == pytest.approx(predict(free.robot, q)[0], abs=2e-6)


def test_a_robot_that_is_already_calibrated_stays_as_it_is():
    _, data = example()
    once = calibrate(arm(), data)
    twice = calibrate(once.robot, data, identify=["[1-6].*"])
    assert twice.residuals["calibrated"].rms <= once.residuals["calibrated"].rms * (1 + 1e-9)
    assert twice.residuals["nominal"].rms == pytest.approx(once.residuals["calibrated"].rms)


def test_the_same_input_gives_the_same_output_to_the_last_bit():
    _, data = example(elastic=True)
    first, second = (calibrate(arm(), data, elastic=ALL_LINEAR, holdout=0.3, seed=4) for _ in range(2))
    assert first.robot == second.robot
    assert first.parameters == second.parameters
    assert first.residuals == second.residuals


def test_inputs_are_not_changed():
    nominal = arm()
    _, data = example()
    before = data.q.copy(), data.position.copy(), data.orientation.copy()
    calibrate(nominal, data, elastic=ALL_LINEAR)
    assert nominal == arm()
    assert all((a == b).all() for a, b in zip(before, (data.q, data.position, data.orientation), strict=True))
