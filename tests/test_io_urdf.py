"""URDFs as robots: where the chain ends, what hangs beside it, limits, names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.robot import Robot
from support.files import URDF, edited

TREE = """\
<?xml version="1.0"?>
<robot name="cell" xmlns:xacro="http://www.ros.org/wiki/xacro">
<link name="world"/>
<link name="pillar"><inertial><mass value="50"/></inertial></link>
<link name="arm"><inertial><origin xyz="0.1 0 0"/><mass value="2"/></inertial></link>
<link name="box"><inertial><origin xyz="0 0 0.5"/><mass value="1"/></inertial></link>
<link name="hand"><inertial><mass value="1"/></inertial></link>
<link name="finger"><inertial><origin xyz="0 0.1 0"/><mass value="1"/></inertial></link>
<link name="other_finger"/>
<transmission name="t"/>
<joint name="foot" type="fixed"><parent link="world"/><child link="pillar"/><origin xyz="0 0 1"/></joint>
<joint name="tool" type="revolute"><parent link="pillar"/><child link="arm"/><axis xyz="0 0 2"/>
<limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
<joint name="boxed" type="fixed"><parent link="arm"/><child link="box"/>
<origin xyz="0 0 1" rpy="1.5707963267948966 0 0"/></joint>
<joint name="slide" type="prismatic"><parent link="arm"/><child link="hand"/><limit lower="0" upper="0"/></joint>
<joint name="grip" type="prismatic"><parent link="hand"/><child link="finger"/><origin xyz="1 0 0"/></joint>
<joint name="grip2" type="prismatic"><parent link="hand"/><child link="other_finger"/><mimic joint="grip"/></joint>
</robot>
"""


def load(folder: Path, text: str, tip: str | None = None) -> Robot:
    """The robot of a URDF."""
    (folder / "robot.urdf").write_text(text)
    return ec.load_robot(folder / "robot.urdf", tip)


def test_the_chain_ends_at_the_tip_and_carries_what_hangs_beside_and_beyond(tmp_path: Path):
    robot = load(tmp_path, TREE, tip="hand")
    foot, arm, hand = robot.rows
    assert [row.name for row in robot.rows] == ["foot", "tool_joint", "slide"]
    assert [row.joint for row in robot.rows] == [None, "revolute", "prismatic"]
    assert (foot.mass, arm.mass, hand.mass) == (50.0, 3.0, 2.0)
    # box: turned about x, its centre half a metre along -y, one metre up
    np.testing.assert_allclose(arm.com, [0.2 / 3.0, -0.5 / 3.0, 1.0 / 3.0], atol=1e-15)
    np.testing.assert_allclose(hand.com, [0.5, 0.05, 0.0])


def test_axes_are_made_units_and_limits_that_say_nothing_are_none(tmp_path: Path):
    _, arm, hand = load(tmp_path, TREE, tip="hand").rows
    assert (arm.axis, arm.limits) == ((0.0, 0.0, 1.0), (-1.0, 2.0))
    assert (hand.axis, hand.limits) == ((1.0, 0.0, 0.0), None)


def test_joints_beyond_the_tip_may_be_of_any_kind(tmp_path: Path):
    assert load(tmp_path, TREE.replace('"grip" type="prismatic"', '"grip" type="floating"'), tip="hand").rows
    with pytest.raises(ec.InputError, match="name its tip"):
        load(tmp_path, TREE)


def test_a_chain_that_does_not_branch_needs_no_tip(tmp_path: Path):
    assert load(tmp_path, URDF) == load(tmp_path, URDF, tip="l2")


def test_a_declared_but_unused_xacro_namespace_does_no_harm(tmp_path: Path):
    head = '<robot name="u" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    assert load(tmp_path, edited(URDF, ('<robot name="u">', head))) == load(tmp_path, URDF)


def test_a_urdf_written_as_a_robot_file_predicts_the_same(tmp_path: Path):
    robot = load(tmp_path, TREE, tip="hand")
    ec.save_robot(robot, tmp_path / "robot.toml")
    again = ec.load_robot(tmp_path / "robot.toml")
    assert again == robot
    q = np.array([[0.3, 0.1], [-0.2, 0.4]])
    np.testing.assert_array_equal(ec.predict(again, q)[0], ec.predict(robot, q)[0])
    np.testing.assert_allclose(ec.predict(robot, np.array([[np.pi / 2, 0.4]]))[0], [[0.0, 0.4, 1.0]], atol=1e-15)
