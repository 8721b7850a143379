"""Columns of robots with every law mixed, transition torques of hinges among them, against central differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elasticity import LAWS
from elastocal.measurements import Measurements
from elastocal.parameters import Group, parameters_of
from elastocal.prediction import Model
from elastocal.robot import Compliance, Robot
from support.differences import central_difference
from support.robots import random_dh_robot
from support.urdf import compliant, equipped
from test_prediction_jacobian import AGREES, FLOOR, columns, observations, observed, residuals

OTHERS = ("2.alpha", "3.a", "5.beta")
STIFFER = 0.3
"""The high compliance of steps and hinges, as a share of the low one."""

APART = 0.01
"""No load is nearer to a transition torque than this share of it, so that the small steps of differences cross none."""


def soft_robot(convention: str, seed: int, turn: float) -> Robot:
    """A robot that gives way everywhere, linearly."""
    rng = np.random.default_rng(seed)
    return compliant(equipped(random_dh_robot(rng, convention, prismatic=0.35), rng), OTHERS, turn, turn / 10.0)


def with_mixed_laws(robot: Robot, data: Measurements, first: int) -> Robot:
    """The robot with laws on its elements in turn, transition torques in the middle of their loads."""
    sizes = Model(robot, (), data).undeflected_loads(np.zeros(0))
    elastic = {}
    for i, (name, compliance) in enumerate(robot.elastic.items(), start=first):
        law = ("step", "hinge", "cubic", "hinge", "step")[i % 5]
        (c,), loads = compliance.coefficients, np.abs(sizes[name])
        if law == "cubic":
            elastic[name] = Compliance(law, (c, -0.2 * c / float((loads**2).max())))
        else:
            elastic[name] = Compliance(law, (c, STIFFER * c), _in_widest_gap(loads))
    return replace(robot, elastic=elastic)


def _in_widest_gap(loads: np.ndarray) -> float:
    """Of the gaps in the middle half of the loads, the middle of the widest."""
    ordered = np.sort(loads)[len(loads) // 4 : -(len(loads) // 4)]
    widest = int(np.argmax(np.diff(ordered)))
    return float(0.5 * (ordered[widest] + ordered[widest + 1]))


def step_of(robot: Robot, name: str, loads: dict[str, np.ndarray]) -> float:
    """A step for a parameter: an angle, a length, or what changes a deflection by as much as a length would."""
    element, _, key = name.rpartition(".")
    if element not in robot.elastic:
        return 2e-4
    compliance = robot.elastic[element]
    if key == "transition_torque":
        return 1e-3 * (compliance.transition_torque or 0.0)
    c = abs(compliance.coefficients[0])
    return 0.01 * (c if key != "c3" else c / float((loads[element] ** 2).max()))


def disagreements(robot: Robot, data: Measurements) -> dict[str, float]:
    """Largest difference of columns from central differences, relative to its largest entry.

    Of all that laws have, and of every fourth of the other parameters.
    """
    jumps = {f"{e}.transition_torque" for e, found in robot.elastic.items() if found.law == "step"}
    names = tuple(name for name in parameters_of(robot) if name not in jumps)
    still = np.zeros(len(names))
    model = observed(Model(robot, names, data), still)
    loads = model.undeflected_loads(still)
    jacobian = columns(model, still)
    errors = {}
    for number, name in enumerate(names):
        if number % 4 and name.rpartition(".")[0] not in robot.elastic:
            continue
        along = np.eye(len(names))[number] * step_of(robot, name, loads)
        difference = -central_difference(lambda t, along=along: residuals(model, along * t), 1.0) / along[number]
        errors[name] = np.abs(jacobian[number] - difference).max() / max(np.abs(difference).max(), FLOOR * _unit(name))
    return errors


def _unit(name: str) -> float:
    """What a column that counts as zero is measured by: a transition torque moves little, a newton metre at a time."""
    return 1e-6 if name.endswith("transition_torque") else 1.0


CASES = [
    ("modified-dh", 5e-5, True, 0),
    ("standard-dh", 5e-5, True, 1),
    ("modified-dh", 1e-6, False, 2),
    ("standard-dh", 1e-6, True, 3),
    ("modified-dh", 5e-5, False, 4),
]


@pytest.mark.parametrize(("convention", "turn", "wrench", "first"), CASES)
def test_every_column_of_mixed_laws_is_the_derivative_of_the_prediction(convention, turn, wrench, first):
    linear = soft_robot(convention, seed=len(convention) + 2 * wrench, turn=turn)
    assert {row.joint for row in linear.rows} == {"revolute", "prismatic"}
    data = observations(linear, np.random.default_rng(7), n=12, wrench=wrench)
    robot = with_mixed_laws(linear, data, first)
    assert {compliance.law for compliance in robot.elastic.values()} == {"step", "hinge", "cubic"}
    loads = Model(robot, (), data).undeflected_loads(np.zeros(0))
    for name, compliance in robot.elastic.items():
        if compliance.transition_torque is not None:
            assert np.abs(np.abs(loads[name]) / compliance.transition_torque - 1.0).min() > APART
            assert (np.abs(loads[name]) > compliance.transition_torque).any()
    wrong = {name: f"{error:.1e}" for name, error in disagreements(robot, data).items() if not error < AGREES}
    assert not wrong


def test_the_cases_above_cover_every_law_on_joints_that_turn_and_slide_and_on_links():
    found = set()
    for convention, turn, wrench, first in CASES:
        linear = soft_robot(convention, seed=len(convention) + 2 * wrench, turn=turn)
        robot = with_mixed_laws(linear, observations(linear, np.random.default_rng(7), 12, wrench), first)
        joints = {row.joint_element: row.joint for row in robot.rows}
        found |= {(compliance.law, joints.get(name, name)) for name, compliance in robot.elastic.items()}
    assert found >= {(law, where) for law in ("step", "hinge", "cubic") for where in ("revolute", "prismatic", *OTHERS)}


def _data() -> Measurements:
    return observations(soft_robot("modified-dh", 11, 1e-5), np.random.default_rng(7), 12, wrench=False)


@pytest.mark.parametrize("law", ["step", "hinge", "cubic"])
def test_a_finite_step_of_a_coefficient_or_torque_moves_robot_and_model_alike(law: str):
    linear, data = soft_robot("modified-dh", 11, 2e-5), _data()
    first = ("step", "hinge", "cubic").index(law)
    robot = with_mixed_laws(linear, data, first)
    loads = Model(robot, (), data).undeflected_loads(np.zeros(0))
    parameters = parameters_of(robot)
    mine = [n for n, p in parameters.items() if p.group in (Group.COMPLIANCE, Group.TRANSITION)]
    mine = [n for n in mine if robot.elastic[n.rpartition(".")[0]].law == law]
    assert {n.rpartition(".")[2] for n in mine} >= set(LAWS[law].coefficients)
    before = residuals(Model(robot, (), data), np.zeros(0))
    for name in mine:
        step = 30.0 * step_of(robot, name, loads)
        moved = residuals(Model(robot.displaced({name: step}), (), data), np.zeros(0))
        model = residuals(Model(robot, (name,), data), np.array([step]))
        np.testing.assert_allclose(moved, model, rtol=0, atol=1e-12, err_msg=name)
        if (law, name.rpartition(".")[2]) != ("step", "transition_torque"):
            assert np.abs(moved - before).max() > 1e-9, name
