"""A displaced robot predicts what the model predicts at these displacements, and nothing else of it changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.measurements import Labels, Measurements
from elastocal.parameters import parameters_of
from elastocal.prediction import Model, predict
from elastocal.robot import Frame, Payload, Robot, Row
from support.robots import random_dh_robot
from support.urdf import compliant, equipped

SAME = 1e-12


def urdf_robot(rng: np.random.Generator) -> Robot:
    axes = rng.normal(size=(5, 3))
    kinds = ("revolute", "prismatic", None, "revolute", "revolute")
    rows = [
        Row(
            name=f"j{i}",
            joint=kind,
            origin=Frame(tuple(rng.uniform(-0.5, 0.5, 3)), tuple(rng.uniform(-1.5, 1.5, 3))),
            axis=tuple((axis / np.linalg.norm(axis)).tolist()),
            mass=float(rng.uniform(1.0, 15.0)),
            com=tuple(rng.uniform(-0.2, 0.2, 3)),
        )
        for i, (kind, axis) in enumerate(zip(kinds, axes, strict=True), start=1)
    ]
    return Robot("tilted", "urdf", tuple(rows), tool_load=Payload(3.0, (0.1, 0.0, 0.1)))


def robot_of(convention: str, others: tuple[str, ...]) -> Robot:
    rng = np.random.default_rng(len(convention))
    bare = urdf_robot(rng) if convention == "urdf" else random_dh_robot(rng, convention, prismatic=0.35)
    return compliant(equipped(bare, rng), others, 5e-5, 5e-6)


def residuals(robot: Robot, names: tuple[str, ...], displacements: np.ndarray) -> np.ndarray:
    """(7, n) what the model leaves of observations at zero."""
    rng = np.random.default_rng(2)
    n = 4
    data = Measurements(
        q=rng.uniform(-1.5, 1.5, (n, robot.positions)),
        position=np.zeros((n, 3)),
        orientation=np.tile(np.eye(3), (n, 1, 1)),
        distance=np.zeros(n),
        station=Labels.of([None, "north", "north", None]),
        target=Labels.of([None, "near", "far", None]),
        load=Labels.of(["heavy", None, "heavy", None]),
        wrench=rng.normal(size=(n, 6)) * 30.0,
    )
    found = np.empty((7, n))
    rows = {"position": slice(0, 3), "orientation": slice(3, 6), "distance": slice(6, 7)}
    for part in Model(robot, names, data).parts(displacements, derivatives=False):
        found[rows[part.kind], part.rows] = part.residual
    return found


def size_of(robot: Robot, name: str) -> float:
    """0.1 rad or m; of a coefficient, a tenth."""
    element = name.rpartition(".")[0]
    return 0.1 * robot.elastic[element].coefficients[0] if element in robot.elastic else 0.1


ROBOTS = {
    "modified-dh": ("2.alpha", "3.a", "tool.tz"),
    "standard-dh": ("2.alpha", "3.a", "tool.tz"),
    "urdf": ("j1.tx", "j4.ty", "tool.tz"),
}


@pytest.mark.parametrize("convention", ROBOTS)
def test_a_finite_step_of_any_parameter_moves_robot_and_model_alike(convention: str) -> None:
    robot = robot_of(convention, ROBOTS[convention])
    names = tuple(parameters_of(robot))
    before = residuals(robot, (), np.zeros(0))
    for name in names:
        step = size_of(robot, name)
        moved = residuals(robot.displaced({name: step}), (), np.zeros(0))
        model = residuals(robot, (name,), np.array([step]))
        np.testing.assert_allclose(moved, model, rtol=0, atol=SAME, err_msg=name)
        assert np.abs(moved - before).max() > 1e-6, name


@pytest.mark.parametrize("convention", ROBOTS)
def test_steps_of_all_parameters_together_move_robot_and_model_alike(convention: str) -> None:
    robot = robot_of(convention, ROBOTS[convention])
    names = tuple(parameters_of(robot))
    signs = np.random.default_rng(3).choice([-1.0, 1.0], len(names))
    steps = signs * [size_of(robot, name) for name in names]
    moved = Model(robot, names, Measurements(np.zeros((0, robot.positions)))).displaced(steps)
    np.testing.assert_allclose(residuals(moved, (), np.zeros(0)), residuals(robot, names, steps), rtol=0, atol=SAME)


def test_elements_whose_axes_do_not_last_cannot_give_way() -> None:
    """A turn of a frame becomes part of it, and would turn the axis of a compliance with it."""
    for convention in ROBOTS:
        robot = robot_of(convention, ())
        assert {row.joint_element for row in robot.joints} <= set(robot.compliant_elements)
        assert not any(name.startswith(("base", "tool")) for name in robot.compliant_elements)
    assert not any(name.endswith((".rx", ".ry", ".rz")) for name in robot_of("urdf", ()).compliant_elements)


@pytest.mark.parametrize("joint", ["j1", "j2", "j4", "j5"])
def test_the_offset_of_a_urdf_joint_becomes_part_of_its_origin(joint: str) -> None:
    robot = replace(robot_of("urdf", ()), coupling=None)
    number = [row.name for row in robot.joints].index(joint)
    kind = robot.joints[number].joint_element
    moved = robot.displaced({kind: 0.1})
    row = next(row for row in moved.rows if row.name == joint)
    assert row.origin != robot.joints[number].origin
    assert replace(row, origin=robot.joints[number].origin) == robot.joints[number]
    q = np.random.default_rng(5).uniform(-1.0, 1.0, (4, 4))
    for ours, theirs in zip(predict(moved, q), predict(robot, q + 0.1 * np.eye(4)[number]), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=SAME)


def test_displacing_there_and_back_leaves_the_predictions() -> None:
    robot = robot_of("urdf", ROBOTS["urdf"])
    for name in parameters_of(robot):
        step = size_of(robot, name)
        back = robot.displaced({name: step}).displaced({name: -step})
        np.testing.assert_allclose(
            residuals(back, (), np.zeros(0)), residuals(robot, (), np.zeros(0)), rtol=0, atol=SAME, err_msg=name
        )


def test_displacing_nothing_returns_an_equal_robot() -> None:
    robot = robot_of("modified-dh", ROBOTS["modified-dh"])
    assert robot.displaced({}) == robot


def test_a_displacement_of_one_row_leaves_masses_joints_and_other_rows() -> None:
    robot = robot_of("modified-dh", ROBOTS["modified-dh"])
    moved = robot.displaced({"3.alpha": 0.1})
    assert moved.rows[2].geometry["alpha"] == robot.rows[2].geometry["alpha"] + 0.1
    assert replace(moved.rows[2], geometry=robot.rows[2].geometry) == robot.rows[2]
    assert replace(moved, rows=robot.rows) == robot


@pytest.mark.parametrize("name", ["3.gamma", "9.alpha", "2.alpha.c_low", "station.south.tx", "target.other.rx", "base"])
def test_a_displacement_of_what_is_no_parameter_is_refused(name: str) -> None:
    with pytest.raises(KeyError, match=name):
        robot_of("modified-dh", ROBOTS["modified-dh"]).displaced({name: 0.1})
