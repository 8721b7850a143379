"""Robots in other forms: common normals, plain tables, corrections, and what is left between two robots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastocal as ec
from elastocal.conversion import (
    aligned_joints,
    dh_table,
    nominal_geometry,
    residuals_left,
    rigid,
    row_changes,
    with_offsets_only,
)
from elastocal.conversion.denavit_hartenberg import passage
from elastocal.errors import InputError
from elastocal.identification import IdentifiedParameter
from elastocal.parameters import parameters_of
from elastocal.robot import Compliance, Robot
from support.exports import CONVENTIONS, about, at_its_base, random_robot, softened
from support.files import flawed
from support.robots import arm
from support.urdf import transform


def poses(robot: Robot, count: int = 20, seed: int = 1) -> np.ndarray:
    return ec.random_poses(robot, count, seed)


def apart(one: Robot, other: Robot, q: np.ndarray) -> float:
    """The largest difference of the tool's position [m] and of any entry of its rotation."""
    return max(np.abs(a - b).max() for a, b in zip(ec.predict(one, q), ec.predict(other, q), strict=True))


@pytest.mark.parametrize("seed", range(20))
def test_a_passage_is_the_transform_it_came_from(seed: int):
    rng = np.random.default_rng(seed)
    given = transform(Rotation.random(random_state=seed).as_matrix(), rng.uniform(-1.0, 1.0, 3))
    found = passage(given)
    again = about("z", found.turn, found.slide) @ about("x", found.alpha, found.a)
    again = again @ about("z", found.next_turn, found.next_slide)
    assert found.beta == 0.0
    assert abs(found.turn) <= 0.5 * np.pi + 1e-9
    np.testing.assert_allclose(again, given, rtol=0, atol=1e-13)


@pytest.mark.parametrize("alpha", [0.0, np.pi])
@pytest.mark.parametrize("a", [0.0, 0.6, -0.6])
def test_parallel_axes_have_a_passage_too(alpha: float, a: float):
    given = about("z", 0.3, 0.0) @ about("x", alpha, a) @ about("z", 0.5, 0.2)
    found = passage(given)
    again = about("z", found.turn, found.slide) @ about("x", found.alpha, found.a)
    again = again @ about("z", found.next_turn, found.next_slide)
    np.testing.assert_allclose(again, given, rtol=0, atol=1e-14)
    assert (found.slide, found.next_slide) == (0.0, pytest.approx(0.2))


@pytest.mark.parametrize("to", ["modified-dh", "standard-dh"])
@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("seed", range(4))
def test_a_plain_table_is_the_same_rigid_robot(seed: int, convention: str, to: str):
    robot = random_robot(np.random.default_rng(seed), convention)
    q = poses(robot)
    found = dh_table(robot, to, q)
    assert not found.tilts
    assert found.robot.convention == to
    assert all(set(row.geometry) == {"theta", "d", "a", "alpha"} for row in found.robot.rows)
    assert [row.name for row in found.robot.rows] == [row.name for row in robot.joints]
    assert apart(found.robot, at_its_base(robot), poses(robot, seed=2)) < 1e-13
    assert found.distance.max() < 1e-13


def test_a_table_is_itself_in_its_own_convention():
    robot = arm()
    found = dh_table(robot, "modified-dh", poses(robot)).robot
    for row, own in zip(found.rows, robot.rows, strict=True):
        for key in ("theta", "d", "a", "alpha"):
            assert row.geometry[key] == pytest.approx(own.geometry[key], abs=1e-15)
    np.testing.assert_allclose(found.base.translation, 0.0, atol=1e-15)
    again = dh_table(dh_table(robot, "standard-dh", poses(robot)).robot, "standard-dh", poses(robot)).robot
    first = dh_table(robot, "standard-dh", poses(robot)).robot
    for row, own in zip(again.rows, first.rows, strict=True):
        assert row.geometry == pytest.approx(own.geometry, abs=1e-13)


@pytest.mark.parametrize("to", ["modified-dh", "standard-dh"])
def test_nearly_parallel_axes_lose_their_tilt_and_the_rest_is_fitted(to: str):
    robot = arm().displaced({"3.beta": 5e-4})
    q = poses(robot, 300)
    found = dh_table(robot, to, q)
    assert list(found.tilts) == [("2", "3")]
    assert found.tilts["2", "3"] == pytest.approx(5e-4, rel=1e-6)
    bare = at_its_base(robot)
    dropped = arm()
    others = poses(robot, 300, seed=2)
    left = np.linalg.norm(ec.predict(found.robot, others)[0] - ec.predict(bare, others)[0], axis=1)
    without = np.linalg.norm(ec.predict(at_its_base(dropped), others)[0] - ec.predict(bare, others)[0], axis=1)
    assert np.sqrt((left**2).mean()) < 0.9 * np.sqrt((without**2).mean())
    assert left.mean() == pytest.approx(found.distance.mean(), rel=0.1)
    assert left.mean() > 1e-5


@pytest.mark.parametrize("to", ["modified-dh", "standard-dh"])
def test_a_far_common_normal_holds_the_tilt(to: str):
    robot = arm().displaced({"3.beta": 5e-4})
    found = dh_table(robot, to, poses(robot), longest=1e4)
    assert not found.tilts
    assert max(abs(row.geometry["d"]) for row in found.robot.rows) > 1000.0
    assert apart(found.robot, at_its_base(robot), poses(robot, 50)) < 1e-9


def test_a_tilt_about_the_common_normal_is_no_loss():
    robot = arm().displaced({"3.alpha": 5e-4})
    found = dh_table(robot, "modified-dh", poses(robot))
    assert not found.tilts
    assert apart(found.robot, at_its_base(robot), poses(robot)) < 1e-13


def test_joints_are_in_frames_whose_z_is_their_axis():
    robot = random_robot(np.random.default_rng(3), "urdf")
    joints, end = aligned_joints(robot)
    q = poses(robot, 1)
    reached = np.eye(4)
    for joint, position in zip(joints, q[0], strict=True):
        turns = joint.row.joint == "revolute"
        reached = reached @ joint.before @ about("z", position * turns, position * (not turns))
    place, turned = ec.predict(at_its_base(robot), q)
    whole = reached @ end @ transform(robot.tool.rotation, robot.tool.translation)
    np.testing.assert_allclose(whole[:3, 3], place[0], atol=1e-13)
    np.testing.assert_allclose(whole[:3, :3], turned[0], atol=1e-13)


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_changes_added_to_the_nominal_robot_give_the_identified_one(convention: str):
    rng = np.random.default_rng(4)
    nominal = random_robot(rng, convention)
    identified = flawed(nominal, rng)
    deltas = {}
    for change in row_changes(nominal, identified):
        deltas |= {f"{change.row.name}.{key}": value for key, value in change.deltas.items()}
        if change.row.joint_element:
            deltas[change.row.joint_element] = change.row.sign * change.offset
    assert apart(nominal.displaced(deltas), identified, poses(nominal)) < 1e-13


def test_changes_of_a_urdf_are_the_turn_about_the_axis_and_the_rest_of_the_origin():
    rng = np.random.default_rng(5)
    nominal = random_robot(rng, "urdf")
    identified = flawed(nominal, rng)
    changes = row_changes(nominal, identified)
    rows = []
    for row, change in zip(nominal.rows, changes, strict=True):
        turn = [change.deltas[key] for key in ("rx", "ry", "rz")]
        own = Rotation.from_matrix(row.origin.rotation) * Rotation.from_euler("XYZ", turn)
        shift = np.array([change.deltas[key] for key in ("tx", "ty", "tz")])
        offset = change.offset * row.sign
        if row.joint == "revolute":
            assert abs(Rotation.from_euler("XYZ", turn).as_rotvec() @ row.axis) < 1e-9
            own = own * Rotation.from_rotvec(offset * np.array(row.axis))
        elif row.joint == "prismatic":
            shift = shift + own.apply(row.axis) * offset
        rows.append(replace(row, origin=row.origin.at(row.origin.translation + shift, own.as_matrix())))
    assert apart(replace(nominal, rows=tuple(rows)), identified, poses(nominal)) < 1e-13


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_nominal_robot_is_known_from_the_identified_parameters(convention: str):
    rng = np.random.default_rng(6)
    nominal = random_robot(rng, convention)
    before = parameters_of(nominal)
    deltas = {name: 1e-3 * rng.standard_normal() for name in before if name.split(".")[0] in _row_names(nominal)}
    identified = nominal.displaced(deltas)
    told = [
        IdentifiedParameter(name, p.unit, p.nominal, (p.nominal or 0.0) + deltas[name], 0.0, "identified")
        for name, p in before.items()
        if name in deltas
    ]
    assert apart(nominal, identified, poses(nominal)) > 1e-4
    assert apart(nominal_geometry(identified, told), nominal, poses(nominal)) < 1e-13


def _row_names(robot: Robot) -> set[str]:
    return {row.name for row in robot.rows}


def test_offsets_alone_are_what_they_say():
    robot = arm()
    turned = robot.displaced({"2.theta": 1e-3, "4.a": 1e-3})
    found = with_offsets_only(robot, row_changes(robot, turned), turned)
    q = poses(robot)
    assert apart(found, robot.displaced({"2.theta": 1e-3}), q) < 1e-15


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda r: replace(r, convention="standard-dh"), "convention 'standard-dh', the identified one 'modified-dh'"),
        (lambda r: replace(r, rows=r.rows[:5]), "has rows 1, 2, 3, 4, 5, the identified one 1, 2, 3, 4, 5, 6"),
        (lambda r: replace(r, rows=(replace(r.rows[0], sign=-1), *r.rows[1:])), "row 1: joint and sign differ"),
    ],
)
def test_another_robot_is_no_nominal_one(edit, message: str):
    with pytest.raises(InputError, match=message):
        row_changes(edit(arm()), arm())


def test_what_is_left_of_a_robot_is_the_difference_of_predictions():
    robot = replace(softened(arm()), base=random_robot(np.random.default_rng(7), "urdf").base)
    reading = at_its_base(rigid(robot))
    q, q_fit = poses(robot, 40), poses(robot, 40, seed=2)
    found = residuals_left(robot, {"geometry": reading}, q, q_fit)
    assert [(r.load, r.refitted) for r in found] == [(None, False), (None, True), ("heavy", False), ("heavy", True)]
    for residual in found[::2]:
        one, other = ec.predict(robot, q, load=residual.load), ec.predict(rigid(robot), q)
        np.testing.assert_allclose(residual.position, np.linalg.norm(one[0] - other[0], axis=1), rtol=0, atol=1e-12)
        turn = Rotation.from_matrix(one[1] @ other[1].transpose(0, 2, 1)).magnitude()
        np.testing.assert_allclose(residual.angle, turn, rtol=0, atol=1e-12)
    for plain, fitted in zip(found[::2], found[1::2], strict=True):
        assert (fitted.position**2).mean() < (plain.position**2).mean()


def test_nothing_is_left_of_a_rigid_robot_but_of_a_soft_one_in_proportion():
    robot = arm()
    q = poses(robot, 30)
    stiff = residuals_left(robot, {"all": at_its_base(rigid(robot))}, q, q)
    assert max(r.position.max() for r in stiff) < 1e-13
    left = []
    for compliance in (1e-7, 2e-7):
        soft = replace(robot, elastic={"2.theta": Compliance("linear", (compliance,))})
        left.append(residuals_left(soft, {"all": at_its_base(rigid(soft))}, q, q)[0].position)
    np.testing.assert_allclose(left[1], 2.0 * left[0], rtol=1e-3)
