"""Forward kinematics and gravity torques against pinocchio, on URDFs written here."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.chain import forward, place
from elastocal.errors import InputError
from elastocal.io.urdf import read_urdf
from elastocal.prediction import predict
from elastocal.robot import Compliance, Robot, assemble
from elastocal.statics import load
from support.robots import arm, random_dh_robot
from support.urdf import Joint, Link, random_tree, robot_urdf, transform, urdf_text

pinocchio = pytest.importorskip("pinocchio", reason="the oracle is not installed: pip install 'elastocal[test]'")

AGREES = 1e-10
POSES = 5


def oracle(text: str, names: list[str], tip: str, q: np.ndarray, gravity: tuple) -> tuple[np.ndarray, ...]:
    """Pinocchio's positions and rotations of the tip, and generalized gravity of the named joints; the others at 0."""
    model = pinocchio.buildModelFromXML(text)
    model.gravity.linear = np.array(gravity)
    data, frame = model.createData(), model.getFrameId(tip)
    rows = [model.joints[model.getJointId(name)].idx_v for name in names]
    positions, rotations, torques = [], [], []
    for pose in q:
        step = np.zeros(model.nv)
        step[rows] = pose
        configuration = pinocchio.integrate(model, pinocchio.neutral(model), step)
        pinocchio.framesForwardKinematics(model, data, configuration)
        positions.append(data.oMf[frame].translation.copy())
        rotations.append(data.oMf[frame].rotation.copy())
        torques.append(pinocchio.computeGeneralizedGravity(model, data, configuration)[rows])
    return np.array(positions), np.array(rotations), np.array(torques)


def loads(robot: Robot, q: np.ndarray) -> np.ndarray:
    """The loads (poses, joints) on the driven elements, in the order of the joints."""
    names = [row.joint_element for row in robot.joints]
    assembly = assemble(replace(robot, elastic={name: Compliance() for name in names}))
    mechanism = assembly.mechanism
    placement = place(mechanism.chain, mechanism.chain.values)
    return load(mechanism, placement, forward(placement, assembly.motion(q.T))).loads.T


def assert_agreement(robot: Robot, q: np.ndarray, theirs: tuple[np.ndarray, ...], signs: np.ndarray) -> None:
    """A load is minus the generalized gravity, of the model's joint: `signs` where the URDF counts against it."""
    position, rotation = predict(replace(robot, elastic={}), q)
    np.testing.assert_allclose(position, theirs[0], rtol=0, atol=AGREES)
    np.testing.assert_allclose(rotation, theirs[1], rtol=0, atol=AGREES)
    size = max(np.abs(theirs[2]).max(), 1.0)
    np.testing.assert_allclose(loads(robot, q) * signs, -theirs[2], rtol=0, atol=AGREES * size)


def read(text: str, folder: Path, tip: str | None) -> Robot:
    path = folder / "robot.urdf"
    path.write_text(text)
    return read_urdf(path, tip)


@pytest.mark.parametrize("seed", range(12))
def test_a_chain_of_all_kinds_of_joints_agrees(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    text = urdf_text(*random_tree(rng, joints=9, branching=0.0))
    robot = read(text, tmp_path, None)
    q = rng.uniform(-3.0, 3.0, (POSES, len(robot.joints)))
    theirs = oracle(text, [row.name for row in robot.joints], "9", q, robot.gravity)
    assert_agreement(robot, q, theirs, np.ones(len(robot.joints)))


@pytest.mark.parametrize("seed", range(12))
def test_every_tip_of_a_tree_agrees_with_side_branches_lumped(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(100 + seed)
    links, joints = random_tree(rng, joints=12, branching=0.5)
    text = urdf_text(links, joints)
    for link in links[1:]:
        try:
            robot = read(text, tmp_path, link.name)
        except InputError as error:
            assert "no joint moves between the root" in str(error)
            continue
        q = rng.uniform(-3.0, 3.0, (POSES, len(robot.joints)))
        theirs = oracle(text, [row.name for row in robot.joints], link.name, q, robot.gravity)
        assert_agreement(robot, q, theirs, np.ones(len(robot.joints)))


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
@pytest.mark.parametrize("seed", range(4))
def test_a_random_dh_robot_agrees_with_itself_written_as_urdf(convention: str, seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    robot = random_dh_robot(rng, convention, prismatic=0.3)
    q = rng.uniform(-3.0, 3.0, (POSES, 6))
    gravity = tuple((robot.base.rotation @ robot.gravity).tolist())
    theirs = oracle(robot_urdf(robot), [row.name for row in robot.rows], "tool", q, gravity)
    assert_agreement(robot, q, theirs, np.array([row.sign for row in robot.rows]))


@pytest.mark.parametrize("seed", range(3))
def test_a_coupled_dh_robot_with_a_fixed_row_agrees_at_the_models_joint_positions(seed: int) -> None:
    rng = np.random.default_rng(300 + seed)
    robot = random_dh_robot(rng, "modified-dh", joints=7, prismatic=0.2)
    fixed = replace(robot.rows[3], joint=None, sign=1)
    matrix = np.eye(6) + np.tril(rng.uniform(-0.5, 0.5, (6, 6)), -1)
    coupled = replace(
        robot, rows=(*robot.rows[:3], fixed, *robot.rows[4:]), coupling=tuple(map(tuple, matrix.tolist()))
    )
    q = rng.uniform(-2.0, 2.0, (POSES, 6))
    gravity = tuple((coupled.base.rotation @ coupled.gravity).tolist())
    names = [row.name for row in coupled.joints]
    theirs = oracle(robot_urdf(coupled), names, "tool", q @ matrix.T, gravity)
    assert_agreement(coupled, q, theirs, np.array([row.sign for row in coupled.joints]))


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_a_dh_robot_written_as_urdf_reads_back_as_the_same_robot(convention: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    robot = random_dh_robot(rng, convention, prismatic=0.3)
    again = read(robot_urdf(robot), tmp_path, "tool")
    again = replace(again, gravity=tuple((robot.base.rotation @ robot.gravity).tolist()))
    signs = np.array([row.sign for row in robot.rows])
    q = rng.uniform(-3.0, 3.0, (POSES, 6))
    for ours, theirs in zip(predict(robot, q), predict(again, q), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        loads(robot, q) * signs, loads(again, q), rtol=0, atol=1e-12 * np.abs(loads(robot, q)).max()
    )


def test_an_ordinary_arm_agrees() -> None:
    robot = arm()
    q = np.random.default_rng(6).uniform(-2.0, 2.0, (50, 6))
    theirs = oracle(robot_urdf(robot), [row.name for row in robot.rows], "tool", q, robot.gravity)
    assert_agreement(robot, q, theirs, np.ones(6))


def test_masses_beyond_the_tip_and_beside_it_count(tmp_path: Path) -> None:
    shift = [transform(np.eye(3), np.array([x, 0.0, 0.0])) for x in (0.0, 0.5, 0.5, 1.0)]
    links = [Link("root"), Link("arm", 1.0), Link("tip", 1.0), Link("beyond", 2.0), Link("beside", 4.0)]
    joints = [
        Joint("shoulder", "revolute", "root", "arm", shift[0], (0.0, 1.0, 0.0)),
        Joint("wrist", "continuous", "arm", "tip", shift[1], (0.0, 1.0, 0.0)),
        Joint("hand", "prismatic", "tip", "beyond", shift[2], (1.0, 0.0, 0.0)),
        Joint("horn", "revolute", "arm", "beside", shift[3], (0.0, 0.0, 1.0)),
    ]
    robot = read(urdf_text(links, joints), tmp_path, "tip")
    # about the y axis a weight at x turns by x m g: arm 0, tip 0.5, beyond 1.0, beside 1.0; about the wrist beyond 0.5
    expected = 9.81 * np.array([[0.5 * 1.0 + 1.0 * 2.0 + 1.0 * 4.0, 0.5 * 2.0]])
    np.testing.assert_allclose(loads(robot, np.zeros((1, 2))), expected, rtol=1e-14)


def test_a_urdf_axis_left_out_is_x_and_any_length_of_one_does(tmp_path: Path) -> None:
    links = [Link("root"), Link("a", 1.0, (0.1, 0.2, 0.3)), Link("b", 1.0, (0.1, 0.2, 0.3))]
    joints = [
        Joint("one", "revolute", "root", "a", np.eye(4)),
        Joint("two", "prismatic", "a", "b", transform(np.eye(3), np.array([0.1, 0.2, 0.3])), (0.0, 7.0, 0.0)),
    ]
    text = urdf_text(links, joints).replace('<axis xyz="1.0 0.0 0.0"/>', "")
    assert text.count("<axis") == 1
    robot = read(text, tmp_path, None)
    q = np.array([[0.3, 0.5], [-1.0, 2.0]])
    assert_agreement(robot, q, oracle(text, ["one", "two"], "b", q, robot.gravity), np.ones(2))
