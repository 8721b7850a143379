"""Faults of a URDF."""

from __future__ import annotations

import pytest

from support.files import TABLE, URDF, Desk, desk, edited

__all__ = ["desk"]

BRANCH = '<link name="l3"/><joint name="j3" type="fixed"><parent link="l1"/><child link="l3"/></joint></robot>'
LOOP = '<joint name="j3" type="fixed"><parent link="l2"/><child link="base_link"/></joint></robot>'
XACRO = "expected a URDF, found a xacro: expand it first: xacro robot.urdf > robot.urdf"
NAMESPACE = '<robot name="u" xmlns:xacro="http://www.ros.org/wiki/xacro">'
KINDS = "expected type revolute, continuous, prismatic or fixed"

FAULTS = {
    "a floating joint": ([('"continuous"', '"floating"')], [f"joint 'j2': {KINDS}, found floating"]),
    "a planar joint": ([('"continuous"', '"planar"')], [f"joint 'j2': {KINDS}, found planar"]),
    "a joint of no type": ([(' type="continuous"', "")], [f"joint 'j2': {KINDS}, found none"]),
    "a mimic joint": (
        [("</joint>\n</robot>", '<mimic joint="j1"/></joint>\n</robot>')],
        ["joint 'j2' mimics another, which this reader cannot: write a robot file with [coupling]"],
    ),
    "no tip where it branches": (
        [("</robot>", BRANCH)],
        ["the chain branches: name its tip (--tip LINK; valid: l2, l3)"],
    ),
    "a link that is not there": (
        [('<parent link="l1"/>', '<parent link="l11"/>')],
        ["joint 'j2', parent: no link 'l11'; did you mean 'l1'? (valid: base_link, l1, l2)"],
    ),
    "a joint without a parent": (
        [('<parent link="l1"/>', "")],
        ["joint 'j2': expected a <parent link=…>, found none"],
    ),
    "two roots": ([("</robot>", '<link name="l3"/></robot>')], ["expected one root link, found base_link, l3"]),
    "a loop": ([("</robot>", LOOP)], ["expected one root link, found none: its joints go round in a loop"]),
    "a link with two parents": (
        [("</robot>", LOOP.replace("l2", "base_link").replace('child link="base_link"', 'child link="l2"'))],
        ["link 'l2' is the child of several joints: expected one"],
    ),
    "joints of one name": ([('"j2"', '"j1"')], ["several joints are named 'j1': names must differ"]),
    "a joint without a name": ([(' name="j2"', "")], ["joint 2 has no name"]),
    "links of one name": ([('name="l2"', 'name="l1"')], ["several links are named 'l1': names must differ"]),
    "words and wrong counts for numbers": (
        [('lower="-3"', 'lower="low"'), ('rpy="1.5 0 0"', 'rpy="1.5 0"'), ("0.3 0 0.4", "0.3 0 nan")],
        [
            "joint 'j1', limit lower: expected a number, found 'low'",
            "joint 'j2', origin xyz: expected 3 numbers, found '0.3 0 nan'",
            "joint 'j2', origin rpy: expected 3 numbers, found '1.5 0'",
        ],
    ),
    "an axis of no direction": (
        [('<axis xyz="0 0 1"/></joint>', '<axis xyz="0 0 0"/></joint>')],
        ["joint 'j2', axis xyz: expected a direction, found zero length"],
    ),
    "reversed limits": (
        [('lower="-3" upper="3"', 'lower="2" upper="1"')],
        ["joint 'j1', limit: expected lower below upper, found 2 and 1"],
    ),
    "a negative mass": (
        [('<link name="l1"/>', '<link name="l1"><inertial><mass value="-2"/></inertial></link>')],
        ["link 'l1', mass value: expected 0 or a positive number, found -2"],
    ),
    "joints that are all fixed": (
        [('"revolute"', '"fixed"'), ('"continuous"', '"fixed"')],
        ["no joint moves between the root and link 'l2'"],
    ),
    "a xacro that includes": ([('<robot name="u">', NAMESPACE + '<xacro:include filename="x"/>')], [XACRO]),
    "a xacro without its namespace": ([('<robot name="u">', '<robot name="u"><xacro:macro/>')], [XACRO]),
    "a xacro with properties": ([("0.3 0 0.4", "${reach} 0 0.4")], [XACRO]),
    "another robot format": (
        [("<robot name", "<sdf name"), ("</robot>", "</sdf>")],
        ["expected a <robot>, found a <sdf>"],
    ),
    "no links": ([(URDF, "<robot/>")], ["expected one root link, found no link at all"]),
}


@pytest.mark.parametrize("case", FAULTS)
def test_a_urdf_with_faults_is_refused_and_each_is_told(desk: Desk, case: str):
    edits, faults = FAULTS[case]
    desk.write(robot_urdf=edited(URDF, *edits), fit_csv=TABLE)
    assert desk.refused("validate robot.urdf fit.csv") == [f"robot.urdf: {fault}" for fault in faults]


@pytest.mark.parametrize("text", ["", "robot", "<robot><link/>"])
def test_what_is_no_xml_is_refused_with_line_and_column(desk: Desk, text: str):
    desk.write(robot_urdf=text, fit_csv=TABLE)
    (fault,) = desk.refused("validate robot.urdf fit.csv")
    assert fault.startswith("robot.urdf: not valid XML: ")
    assert "line 1, column " in fault


def test_an_unknown_tip_is_told_with_those_that_exist(desk: Desk):
    desk.write(robot_urdf=URDF, fit_csv=TABLE)
    expected = "robot.urdf: --tip: no link 'l3'; did you mean 'l2'? (valid: base_link, l1, l2)"
    assert desk.refused("validate robot.urdf fit.csv --tip l3") == [expected]


def test_the_root_as_a_tip_leaves_no_joint(desk: Desk):
    desk.write(robot_urdf=URDF, fit_csv=TABLE)
    expected = "robot.urdf: no joint moves between the root and link 'base_link'"
    assert desk.refused("validate robot.urdf fit.csv --tip base_link") == [expected]


def test_a_file_that_is_called_a_xacro_is_judged_by_what_it_holds(desk: Desk):
    desk.write(robot_xacro=edited(URDF, ("0.3 0 0.4", "${reach} 0 0.4")), plain_xacro=URDF, fit_csv=TABLE)
    (fault,) = desk.refused("validate robot.xacro fit.csv")
    assert fault == "robot.xacro: expected a URDF, found a xacro: expand it first: xacro robot.xacro > robot.urdf"
    desk.done("validate plain.xacro fit.csv")
