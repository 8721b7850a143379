"""The forward pass: frames, marks and the target of a chain, against slow plain matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.chain import Chain, Element, forward, orientations, place, points
from elastocal.robot import Frame, Robot, Row, assemble
from support.robots import random_dh_robot
from support.urdf import compliant, equipped, posed

WHERE = (None, None, None), ("north", "near", "heavy"), (None, "far", None)
ROUNDING = 1e-13


def urdf_robot(rng: np.random.Generator) -> Robot:
    """Revolute, prismatic and fixed rows with tilted axes, two of them along -z and z."""
    axes = [*(v / np.linalg.norm(v) for v in rng.normal(size=(5, 3))), np.array([0.0, 0.0, -1.0]), np.eye(3)[2]]
    kinds = ("revolute", "prismatic", None, "revolute", "revolute", "revolute", "prismatic")
    frames = [Frame(tuple(rng.uniform(-0.5, 0.5, 3)), tuple(rng.uniform(-3.0, 3.0, 3))) for _ in axes]
    rows = tuple(
        Row(f"j{i}", kind, origin=frame, axis=tuple(axis.tolist()), sign=int(rng.choice([-1, 1])), mass=1.0)
        for i, (kind, axis, frame) in enumerate(zip(kinds, axes, frames, strict=True), start=1)
    )
    return Robot("tilted", "urdf", rows)


def robots() -> dict[str, Robot]:
    rng = np.random.default_rng(1)
    made = {name: random_dh_robot(rng, name, prismatic=0.4) for name in ("modified-dh", "standard-dh")}
    return {name: equipped(robot, rng) for name, robot in {**made, "urdf": urdf_robot(rng)}.items()}


@pytest.mark.parametrize("where", WHERE, ids=["base", "station, near, heavy", "far"])
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh", "urdf"])
@pytest.mark.parametrize("others", [(), ("tool.rz", "tool.tx")], ids=["rigid", "tool gives way"])
def test_marks_and_target_are_where_plain_matrices_put_them(convention: str, where: tuple, others: tuple) -> None:
    robot = compliant(robots()[convention], others, 0.0, 0.0)
    robot = robot if others else replace(robot, elastic={})
    q = np.random.default_rng(2).uniform(-3.0, 3.0, (5, robot.positions))
    assembly = assemble(robot, *where)
    chain = assembly.mechanism.chain
    placement = place(chain, chain.values)
    frames = forward(placement, assembly.motion(q.T))
    tip = frames.axes.shape[1] - 1
    found_at = [points(frames, tip, placement.tip_origin)]
    found_turned = [orientations(frames, tip, placement.tip_rotation)]
    for mark, frame in enumerate(chain.mark_frames):
        found_at.append(points(frames, frame, placement.mark_origins[mark]))
        found_turned.append(orientations(frames, frame, placement.mark_rotations[mark]))
    for i, position in enumerate(q):
        pose = posed(robot, position, {}, *where)
        expected = [pose.frames[-1], *pose.frames[: pose.tool + 1]]
        for at, turned, frame in zip(found_at, found_turned, expected, strict=True):
            np.testing.assert_allclose(at[:, i], frame[:3, 3], rtol=0, atol=ROUNDING)
            np.testing.assert_allclose(turned[:, :, i], frame[:3, :3], rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh", "urdf"])
def test_screws_are_axes_and_origins_of_the_elements(convention: str) -> None:
    robot = robots()[convention]
    q = np.random.default_rng(3).uniform(-3.0, 3.0, robot.positions)
    assembly = assemble(robot, "north", "near")
    chain = assembly.mechanism.chain
    placement = place(chain, chain.values)
    frames = forward(placement, assembly.motion(q[:, None]))
    pose = posed(robot, q, {}, "north", "near")
    for element, screw in zip(chain.elements, placement.screws, strict=True):
        if element.name:
            turns, axis, origin, _ = pose.screws[element.name]
            frame = chain.frame_of[chain.index[element.name]]
            turn, shift = frames.axes[:, frame, :, 0], frames.origins[:, frame, 0]
            angular = turn @ screw[3:]
            linear = turn @ screw[:3] + np.cross(shift, angular)
            np.testing.assert_allclose(angular, axis if turns else np.zeros(3), rtol=0, atol=ROUNDING)
            np.testing.assert_allclose(linear, np.cross(origin, axis) if turns else axis, rtol=0, atol=ROUNDING)


def test_half_a_turn_is_as_exact_as_any_other_angle() -> None:
    chain = Chain((Element("a", True, (0.0, 0.0, 1.0)), Element("b", False, (1.0, 0.0, 0.0), 1.0)), (0,), (1,))
    placement = place(chain, chain.values)
    angles = np.array([[np.pi, -np.pi, np.nextafter(np.pi, 4.0), 3.0 * np.pi, 0.5 * np.pi, 0.0, 1e-9, 100.0]])
    at = points(forward(placement, angles), 1, placement.tip_origin)
    np.testing.assert_allclose(at, [np.cos(angles[0]), np.sin(angles[0]), np.zeros(8)], rtol=0, atol=1e-15)


def test_no_drift_over_many_turns_of_many_joints() -> None:
    rng = np.random.default_rng(5)
    robot = random_dh_robot(rng, "modified-dh", joints=30)
    assembly = assemble(robot)
    placement = place(assembly.mechanism.chain, assembly.mechanism.chain.values)
    frames = forward(placement, assembly.motion(rng.uniform(-50.0, 50.0, (30, 4))))
    last = frames.axes[:, -1]
    np.testing.assert_allclose(np.einsum("can,cbn->abn", last, last), np.eye(3)[:, :, None] * np.ones(4), atol=2e-14)
