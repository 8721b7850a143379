"""Equilibrium: deflections are what the loads of the deflected configuration cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.chain import place
from elastocal.elasticity import Equilibrium, settle
from elastocal.errors import EquilibriumError
from elastocal.prediction import predict
from elastocal.robot import Compliance, Payload, Robot, assemble
from support.robots import arm, placed, random_dh_robot
from support.urdf import Pose, compliant, equipped, posed

OTHERS = ("2.alpha", "3.a", "5.beta", "tool.rx", "tool.tz")
HEAVY = ("north", "near", "heavy")
DEG = np.pi / 180.0


def soft(convention: str, turn: float, seed: int = 1) -> Robot:
    rng = np.random.default_rng(seed)
    return compliant(equipped(random_dh_robot(rng, convention, prismatic=0.35), rng), OTHERS, turn, turn / 10.0)


def settled(robot: Robot, q: np.ndarray, where: tuple, wrench: np.ndarray | None) -> tuple[Equilibrium, list[str]]:
    """The equilibrium and the names of the elements that give way."""
    assembly = assemble(robot, *where)
    mechanism = assembly.mechanism
    placement = place(mechanism.chain, mechanism.chain.values)
    found = settle(mechanism, placement, assembly.springs, assembly.motion(q.T), None if wrench is None else wrench.T)
    return found, [mechanism.chain.elements[i].name for i in mechanism.elastic]


def deflected(robot: Robot, q: np.ndarray, where: tuple, found: Equilibrium, names: list[str]) -> list[Pose]:
    """By slow plain matrices, the poses with the elements at their deflections."""
    return [
        posed(robot, p, dict(zip(names, d, strict=True)), *where) for p, d in zip(q, found.deflections.T, strict=True)
    ]


def scene(convention: str, turn: float, pulled: bool) -> tuple[Robot, np.ndarray, np.ndarray | None]:
    rng = np.random.default_rng(3)
    q = rng.uniform(-2.0, 2.0, (6, 6))
    return soft(convention, turn), q, rng.normal(size=(6, 6)) * ([60.0] * 3 + [20.0] * 3) if pulled else None


@pytest.mark.parametrize("turn", [1e-7, 1e-5, 2e-4], ids=["stiff", "ordinary", "soft"])
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
@pytest.mark.parametrize("pulled", [False, True], ids=["gravity", "gravity and wrench"])
def test_deflection_is_compliance_times_load_of_the_deflected_robot(convention: str, turn: float, pulled: bool) -> None:
    robot, q, wrench = scene(convention, turn, pulled)
    found, names = settled(robot, q, HEAVY, wrench)
    poses = deflected(robot, q, HEAVY, found, names)
    compliance = np.array([robot.elastic[name].coefficients[0] for name in names])
    loads = [[pose.load(n, None if wrench is None else wrench[i]) for n in names] for i, pose in enumerate(poses)]
    size = np.abs(found.deflections).max()
    assert (size > 3.0 * DEG) == (turn == 2e-4)
    np.testing.assert_allclose(found.deflections, compliance[:, None] * np.array(loads).T, rtol=0, atol=1e-12 * size)


@pytest.mark.parametrize("turn", [1e-5, 2e-4], ids=["ordinary", "soft"])
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_prediction_is_where_the_deflected_robot_is(convention: str, turn: float) -> None:
    robot, q, wrench = scene(convention, turn, pulled=True)
    station, target, payload = HEAVY
    position, rotation = predict(robot, q, station=station, target=target, load=payload, wrench=wrench)
    poses = deflected(robot, q, HEAVY, *settled(robot, q, HEAVY, wrench))
    np.testing.assert_allclose(position, [pose.frames[-1][:3, 3] for pose in poses], rtol=0, atol=1e-12)
    np.testing.assert_allclose(rotation, [pose.frames[-1][:3, :3] for pose in poses], rtol=0, atol=1e-12)


def test_without_gravity_nothing_deflects() -> None:
    robot, q, _ = scene("modified-dh", 2e-4, pulled=False)
    robot = replace(robot, gravity=(0.0, 0.0, 0.0))
    assert not settled(robot, q, HEAVY, None)[0].deflections.any()
    for ours, rigid in zip(predict(robot, q), predict(replace(robot, elastic={}), q), strict=True):
        np.testing.assert_allclose(ours, rigid, rtol=0, atol=1e-14)


def test_a_compliance_of_zero_is_rigid() -> None:
    robot, q, wrench = scene("standard-dh", 0.0, pulled=True)
    for ours, rigid in zip(predict(robot, q, wrench=wrench), predict(replace(robot, elastic={}), q), strict=True):
        np.testing.assert_allclose(ours, rigid, rtol=0, atol=1e-14)


@pytest.mark.parametrize("turn", [1e-5, 2e-4], ids=["ordinary", "soft"])
def test_doubling_stiffness_masses_and_wrench_leaves_the_deflections(turn: float) -> None:
    robot, q, wrench = scene("modified-dh", turn, pulled=True)
    payload = robot.loads["heavy"]
    double = replace(
        robot,
        rows=tuple(replace(row, mass=2.0 * row.mass) for row in robot.rows),
        tool_load=replace(robot.tool_load, mass=2.0 * robot.tool_load.mass),
        loads={"heavy": replace(payload, mass=2.0 * payload.mass)},
        elastic={n: Compliance("linear", (0.5 * c.coefficients[0],)) for n, c in robot.elastic.items()},
    )
    before, after = settled(robot, q, HEAVY, wrench)[0], settled(double, q, HEAVY, 2.0 * wrench)[0]
    size = np.abs(before.deflections).max()
    np.testing.assert_allclose(before.deflections, after.deflections, rtol=0, atol=1e-12 * size)


def test_compliance_about_a_vertical_axis_is_invisible_under_gravity() -> None:
    stiff = placed(arm(elastic=True), np.random.default_rng(3))
    loose = replace(stiff, elastic={**stiff.elastic, "1.theta": Compliance("linear", (1e-3,))})
    q = np.random.default_rng(4).uniform(-1.5, 1.5, (20, 6))
    np.testing.assert_allclose(predict(stiff, q)[0], predict(loose, q)[0], rtol=0, atol=1e-12)


def test_a_pendulum_hangs_where_its_spring_holds_it() -> None:
    robot = replace(arm(tool_mass=0.0), rows=arm().rows[:2], tool_load=Payload(), elastic={})
    robot = replace(robot, elastic={"2.theta": Compliance("linear", (5e-4,))})
    found, _ = settled(robot, np.array([[0.0, 0.3]]), (None, None, None), None)
    mass, (x, y, _) = robot.rows[1].mass, robot.rows[1].com
    angle = 0.3 + found.deflections[0, 0]  # the second axis lies level, x level and y down at zero
    torque = 9.81 * mass * (x * np.cos(angle) - y * np.sin(angle))
    assert found.deflections[0, 0] == pytest.approx(5e-4 * torque, rel=1e-12)
    assert found.deflections[0, 0] > 2.0 * DEG


def arm_on_a_soft_shoulder(compliance: float) -> Robot:
    springs = {"2.theta": Compliance("linear", (compliance,)), "3.theta": Compliance("linear", (1e-6,))}
    return replace(arm(), elastic=springs)


UPRIGHT = np.array([[0.0, -90.0, -90.0, 0.0, 0.0, 0.0]]) * DEG


def test_a_robot_too_soft_to_stand_is_refused() -> None:
    with pytest.raises(EquilibriumError, match=r"does not settle under its load.*too soft for what hangs on it"):
        predict(arm_on_a_soft_shoulder(1e-2), UPRIGHT)


def test_a_robot_too_soft_is_named_with_element_and_pose() -> None:
    folded = np.array([[0.0, 0.0, 60.0 * DEG, 0.0, 0.0, 0.0]])
    robot = arm_on_a_soft_shoulder(2e-3)
    assert np.isfinite(predict(robot, folded)[0]).all()
    with pytest.raises(EquilibriumError, match=r"does not settle under its load") as error:
        predict(robot, np.concatenate([folded, folded, UPRIGHT, folded]))
    assert (error.value.element, error.value.pose) == ("2.theta", 2)


def test_a_robot_softer_than_any_is_refused_without_a_warning() -> None:
    with pytest.raises(EquilibriumError):
        predict(arm_on_a_soft_shoulder(0.2), UPRIGHT)
