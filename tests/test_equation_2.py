"""Equation (2) of the paper on nonlinear joint stiffness: which compliance acts in which rows.

With rows LL (both loads below their transition torques), HH, HL and LH one after the other, the columns of C_L2, C_H2,
C_L3 and C_H3 are blocks of the linear law's two columns and zeros.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.measurements import Measurements
from elastocal.prediction import Model
from elastocal.robot import Compliance, Robot
from elastocal.simulation import random_poses
from support.robots import arm, placed

PAPER = {
    "LL": ("2L", "0", "3L", "0"),
    "HH": ("0", "2H", "0", "3H"),
    "HL": ("0", "2H", "3L", "0"),
    "LH": ("2L", "0", "0", "3H"),
}
"""The matrix as printed, J_stif of a joint and side, or zero."""

NAMES = ("2.theta.c_low", "2.theta.c_high", "3.theta.c_low", "3.theta.c_high")

TORQUES = {"2.theta": 222.0, "3.theta": 80.0}

COMPLIANCES = {
    "of a rigid robot": (0.0, 0.0, 0.0, 0.0),
    "of a linear robot": (2e-6, 2e-6, 4e-6, 4e-6),
    "of a robot with steps": (6e-6, 2e-6, 1e-5, 4e-6),
    "of a soft robot with steps": (6e-5, 2e-5, 1e-4, 4e-5),
}


AGREES = 1e-8
"""Relative to the column: how deflections move one another is summed up to here."""


def measurements(robot: Robot) -> Measurements:
    """Full poses; what was observed at them does not matter."""
    q = random_poses(robot, 60, 0)
    return Measurements(q, position=np.zeros((len(q), 3)), orientation=np.tile(np.eye(3), (len(q), 1, 1)))


def columns(robot: Robot, names: tuple[str, ...], data: Measurements) -> np.ndarray:
    """(poses, 6, parameters)."""
    position, orientation = Model(robot, names, data).parts(np.zeros(len(names)))
    return np.concatenate([position.jacobian[:, :-1], orientation.jacobian[:, :-1]]).transpose(2, 0, 1)


def stepped(values: tuple[float, ...]) -> Robot:
    springs = {
        "2.theta": Compliance("step", values[:2], TORQUES["2.theta"]),
        "3.theta": Compliance("step", values[2:], TORQUES["3.theta"]),
    }
    return replace(placed(arm(), np.random.default_rng(0)), elastic=springs)


def linear(shoulder: float, elbow: float) -> Robot:
    springs = {"2.theta": Compliance("linear", (shoulder,)), "3.theta": Compliance("linear", (elbow,))}
    return replace(stepped((0.0,) * 4), elastic=springs)


def groups(robot: Robot, data: Measurements) -> dict[str, np.ndarray]:
    """The rows by their sides, in the paper's order."""
    loads = Model(robot, (), data).undeflected_loads(np.zeros(0))
    sides = {name: np.where(np.abs(loads[name]) >= torque, "H", "L") for name, torque in TORQUES.items()}
    both = np.char.add(sides["2.theta"], sides["3.theta"])
    return {group: np.flatnonzero(both == group) for group in PAPER}


@pytest.mark.parametrize("values", COMPLIANCES.values(), ids=COMPLIANCES)
def test_the_matrix_has_the_zero_blocks_of_the_paper_and_the_linear_columns_elsewhere(values):
    robot = stepped(values)
    data = measurements(robot)
    found = columns(robot, NAMES, data)
    compliance = dict(zip(("2L", "2H", "3L", "3H"), values, strict=True))
    for group, rows in groups(robot, data).items():
        assert len(rows) > 2
        # on these rows the robot is one with linear joints, of the compliances of this side
        alike = linear(compliance[f"2{group[0]}"], compliance[f"3{group[1]}"])
        blocks = columns(alike, ("2.theta.c", "3.theta.c"), data)[rows]
        for column, block in enumerate(PAPER[group]):
            if block == "0":
                assert not found[rows, :, column].any()
                continue
            expected = blocks[..., int(block[0]) - 2]
            assert np.abs(expected).max() > 10.0
            np.testing.assert_allclose(found[rows, :, column], expected, rtol=0, atol=AGREES * np.abs(expected).max())


@pytest.mark.parametrize("law", ["step", "hinge"])
@pytest.mark.parametrize("values", [COMPLIANCES["of a rigid robot"], COMPLIANCES["of a linear robot"]])
def test_the_columns_of_the_two_sides_add_up_to_the_linear_column(values, law):
    robot = stepped(values)
    robot = replace(robot, elastic={e: replace(found, law=law) for e, found in robot.elastic.items()})
    data = measurements(robot)
    found = columns(robot, NAMES, data)
    expected = columns(linear(values[0], values[2]), ("2.theta.c", "3.theta.c"), data)
    np.testing.assert_allclose(found[..., 0] + found[..., 1], expected[..., 0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found[..., 2] + found[..., 3], expected[..., 1], rtol=0, atol=1e-9)


def test_the_system_has_full_rank_with_rows_of_all_four_kinds_and_not_with_one():
    robot = stepped((0.0,) * 4)
    data = measurements(robot)
    found, by_group = columns(robot, NAMES, data), groups(robot, data)
    scale = np.abs(found).max(axis=(0, 1))
    assert np.linalg.matrix_rank((found / scale).reshape(-1, 4)) == 4
    for rows in by_group.values():
        assert np.linalg.matrix_rank((found / scale)[rows].reshape(-1, 4)) == 2
    two = np.concatenate([by_group["LL"], by_group["HH"]])
    assert np.linalg.matrix_rank((found / scale)[two].reshape(-1, 4)) == 4
