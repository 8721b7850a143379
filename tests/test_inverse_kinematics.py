"""Inverse kinematics: what forward kinematics does, undone, on robots of every kind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.compensation.machine import joint_limits
from elastocal.robot import Frame, Robot, Row
from support.robots import arm, random_dh_robot
from support.urdf import robot_urdf

TURN = np.pi


def scara() -> Robot:
    """Two parallel turns, a slide and a turn of the flange."""
    rows = (
        Row("1", "revolute", {"d": 0.4}, limits=(-2.3, 2.3)),
        Row("2", "revolute", {"a": 0.35}, limits=(-2.5, 2.5)),
        Row("3", "prismatic", {"a": 0.3, "alpha": np.pi}, limits=(0.0, 0.25)),
        Row("4", "revolute", {}, limits=(-3.1, 3.1)),
    )
    return Robot("scara", "modified-dh", rows)


def on_gantry() -> Robot:
    """The arm on two slides: eight joints."""
    slides = (
        Row("x", "prismatic", {"alpha": np.pi / 2}, limits=(-1.0, 1.0)),
        Row("y", "prismatic", {"alpha": np.pi / 2}, limits=(0.0, 1.5)),
    )
    return replace(arm(), name="gantry", rows=(*slides, *arm().rows))


def parallelogram() -> Robot:
    """The arm whose third joint is counted from the horizontal."""
    matrix = np.eye(6)
    matrix[2, 1] = -1.0
    rows = tuple(replace(row, limits=(-2.0, 2.0)) for row in arm().rows)
    return replace(arm(), rows=rows, coupling=tuple(map(tuple, matrix.tolist())))


ROBOTS = {
    "6R": arm(),
    "7R": random_dh_robot(np.random.default_rng(4), "standard-dh", joints=7),
    "6R of any shape": random_dh_robot(np.random.default_rng(5), "modified-dh"),
    "with slides": random_dh_robot(np.random.default_rng(6), "modified-dh", joints=8, prismatic=0.4),
    "scara": scara(),
    "gantry": on_gantry(),
    "parallelogram": parallelogram(),
    "5R": random_dh_robot(np.random.default_rng(7), "modified-dh", joints=5),
    "one joint": replace(arm(), rows=arm().rows[:1], tool=Frame((0.3, 0.0, 0.0), (0.0, 0.0, 0.0), known=True)),
}


def at_base(robot: Robot) -> Robot:
    return replace(robot, base=Frame())


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("seed", [1, 2])
def test_poses_are_found_again(name: str, seed: int):
    robot = at_base(ROBOTS[name])
    positions, rotations = ec.predict(robot, ec.random_poses(robot, 150, seed))
    q, reached = ec.inverse_kinematics(robot, (positions, rotations))
    found, turned = ec.predict(robot, q)
    assert reached.mean() > 0.98
    np.testing.assert_allclose(found[reached], positions[reached], atol=2e-9)
    np.testing.assert_allclose(turned[reached], rotations[reached], atol=2e-9)
    low, high = joint_limits(robot)
    assert (q >= low).all()
    assert (q <= high).all()


@pytest.mark.parametrize("name", ["6R", "7R", "scara", "gantry"])
def test_positions_alone_are_found_again(name: str):
    robot = at_base(ROBOTS[name])
    positions, _ = ec.predict(robot, ec.random_poses(robot, 200, 3))
    q, reached = ec.inverse_kinematics(robot, positions)
    assert reached.mean() > 0.99
    np.testing.assert_allclose(ec.predict(robot, q)[0][reached], positions[reached], atol=2e-9)


def test_a_urdf_is_solved_as_the_robot_it_describes(tmp_path):
    robot = arm()
    path = tmp_path / "robot.urdf"
    path.write_text(robot_urdf(robot))
    read = at_base(ec.load_robot(path, tip="tool"))
    targets = ec.predict(read, ec.random_poses(read, 100, 2))
    q, reached = ec.inverse_kinematics(read, targets)
    assert reached.mean() > 0.98
    np.testing.assert_allclose(ec.predict(read, q)[0][reached], targets[0][reached], atol=2e-9)


def test_the_preferred_configuration_is_taken():
    robot = arm()
    q = np.array([0.4, -0.6, 0.9, 0.3, 0.7, -0.2])
    flipped = np.array([0.4, -0.6, 0.9, 0.3 - TURN, -0.7, -0.2 + TURN])
    targets = ec.predict(robot, q[None])
    for start in (q, flipped):
        near = start + 0.05
        np.testing.assert_allclose(ec.inverse_kinematics(robot, targets, start=near)[0][0], start, atol=1e-8)


def path_of(robot: Robot, rows: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joint positions on a smooth way, and where they lead."""
    t = np.linspace(0.0, 1.0, rows)[:, None]
    start = np.array([-1.0, -0.9, 1.2, 0.4, 0.8, -0.5, 0.3][: robot.positions])
    way = np.array([2.0, 0.5, -0.7, 0.6, 0.5, 1.0, 0.4][: robot.positions])
    q = start + way * t
    return (q, *ec.predict(robot, q))


@pytest.mark.parametrize("rows", [60, 900, 4500])
def test_a_path_stays_in_one_configuration(rows: int):
    robot = arm()
    q, *targets = path_of(robot, rows)
    found, reached = ec.inverse_kinematics(robot, tuple(targets), start=q[0])
    assert reached.all()
    np.testing.assert_allclose(found, q, atol=1e-6)


def test_a_path_of_a_redundant_robot_is_continuous():
    robot = at_base(on_gantry())
    q = np.column_stack([np.full((300, 2), 0.4), path_of(arm(), 300)[0]])
    targets = ec.predict(robot, q)
    found, reached = ec.inverse_kinematics(robot, targets, start=q[0])
    assert reached.all()
    assert np.abs(np.diff(found, axis=0)).max() < 0.35


def test_shortest_steps_leave_alone_what_need_not_move():
    """A slide that the target lies along, and a parallel one: both take half of the way."""
    rows = (Row("1", "prismatic", {}, limits=(-1.0, 1.0)), Row("2", "prismatic", {}, limits=(-1.0, 1.0)))
    robot = Robot("slides", "modified-dh", rows)
    q, reached = ec.inverse_kinematics(robot, np.array([[0.0, 0.0, 0.6]]), start=[0.0, 0.0])
    assert reached.all()
    np.testing.assert_allclose(q.sum(axis=1), 0.6, atol=1e-12)


def test_out_of_reach_ends_as_near_as_possible():
    robot = arm()
    _, reached = ec.inverse_kinematics(robot, np.array([[5.0, 0.0, 0.5], [0.8, 0.1, 0.6]]))
    assert reached.tolist() == [False, True]
    q, _ = ec.inverse_kinematics(robot, np.array([[5.0, 0.0, 0.5]]))
    away = np.linalg.norm(ec.predict(robot, q)[0] - [5.0, 0.0, 0.5])
    tried = ec.predict(robot, ec.random_poses(robot, 20000, 0))[0]
    assert away < np.linalg.norm(tried - [5.0, 0.0, 0.5], axis=1).min()


def test_no_targets_are_no_solutions():
    q, reached = ec.inverse_kinematics(arm(), np.empty((0, 3)))
    assert q.shape == (0, 6)
    assert reached.shape == (0,)


def test_wrong_shapes_are_named():
    with pytest.raises(ec.InputError, match="orientation: expected an array") as caught:
        ec.inverse_kinematics(arm(), (np.zeros((2, 3)), np.zeros((3, 3))), start=None)
    assert "found (3, 3)" in str(caught.value)
    with pytest.raises(ec.InputError, match="start: expected 6 joint positions, found 2"):
        ec.inverse_kinematics(arm(), np.zeros((1, 3)), start=[0.0, 0.0])
    with pytest.raises(ec.InputError, match=r"position: expected numbers, found .* in row 2"):
        ec.inverse_kinematics(arm(), np.array([[0.0, 0.0, 1.0], [np.nan, 0.0, 1.0]]))
