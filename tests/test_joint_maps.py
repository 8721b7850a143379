"""Joint maps: their columns, their harmonics, and the robots that they lead to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.parameters import parameters_of
from elastocal.prediction import Model, predict
from elastocal.robot import JointMap, Robot, harmonics
from elastocal.simulation import random_poses, simulate
from support.robots import arm, placed, random_dh_robot


def mapped(robot: Robot, seed: int, orders: int = 4) -> Robot:
    """The robot with a map of 1 mrad on each joint."""
    rng = np.random.default_rng(seed)
    maps = {
        row.joint_element: JointMap(*(tuple(1e-3 * rng.standard_normal(orders)) for _ in range(2)))
        for row in robot.joints
    }
    return replace(robot, transmission=maps)


def test_harmonics_are_sines_and_cosines_of_all_orders():
    q = np.random.default_rng(0).uniform(-7.0, 7.0, 50)
    orders = np.arange(1, 101)[:, None]
    found = harmonics(q, 100)
    np.testing.assert_allclose(found[::2], np.sin(orders * q), rtol=0, atol=1e-12)
    np.testing.assert_allclose(found[1::2], np.cos(orders * q), rtol=0, atol=1e-12)


def test_no_orders_are_no_error():
    np.testing.assert_array_equal(JointMap().at(np.linspace(0.0, 1.0, 5)), np.zeros(5))


@pytest.mark.parametrize("seed", range(4))
def test_columns_of_maps_agree_with_central_differences(seed: int):
    rng = np.random.default_rng(seed)
    robot = placed(arm(elastic=True), rng) if seed == 0 else random_dh_robot(rng, "modified-dh", prismatic=0.3)
    if seed == 3:
        robot = replace(robot, coupling=tuple(map(tuple, np.eye(6) + 0.1 * rng.standard_normal((6, 6)))))
    robot = mapped(robot, seed)
    q = random_poses(robot, 7, seed)
    names = tuple(n for n in parameters_of(robot) if ".sin" in n or ".cos" in n)
    names = (*names[::3], "2.alpha", *(["2.theta.c"] if robot.elastic else []))
    at, steps = 1e-4 * rng.standard_normal(len(names)), np.full(len(names), 1e-5)
    if robot.elastic:
        at[-1], steps[-1] = 1e-7, 1e-8
    moved = robot.displaced(dict(zip(names, at.tolist(), strict=True)))  # where the rotation vectors are zero
    model = Model(robot, names, simulate(moved, q, kinds=("position", "orientation", "distance")))
    parts = list(model.parts(at))
    for column in range(len(names)):
        change = np.zeros(len(names))
        change[column] = steps[column]
        ahead, behind = (list(model.parts(at + sign * change, derivatives=False)) for sign in (1, -1))
        for part, plus, minus in zip(parts, ahead, behind, strict=True):
            slope = (minus.residual - plus.residual) / (2.0 * change[column])
            scale = np.abs(slope).max() + 1e-3
            np.testing.assert_allclose(part.jacobian[:, column], slope, rtol=0, atol=1e-6 * scale)


def test_a_displaced_map_is_the_map_that_the_model_steps_to():
    robot = mapped(placed(arm(), np.random.default_rng(1)), 1)
    q = random_poses(robot, 5, 2)
    names = ("2.theta.sin3", "2.theta.cos1", "6.theta.sin4")
    model = Model(robot, names, simulate(robot, q))
    at = np.array([2e-3, -1e-3, 3e-3])
    moved = model.displaced(at)
    assert moved.transmission["2.theta"].sin[2] == pytest.approx(robot.transmission["2.theta"].sin[2] + 2e-3)
    residual = np.concatenate([p.residual.T for p in model.parts(at, derivatives=False)])
    np.testing.assert_allclose(residual, predict(robot, q)[0] - predict(moved, q)[0], rtol=0, atol=1e-14)


def test_an_order_that_the_map_does_not_have_is_no_parameter():
    with pytest.raises(KeyError, match=r"2\.theta\.sin9"):
        mapped(arm(), 0).displaced({"2.theta.sin9": 1e-3})
