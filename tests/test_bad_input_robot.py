"""Faults of a robot file: each is named with its place, what was expected and what was found."""

from __future__ import annotations

import pytest

from support.files import ROBOT, TABLE, Desk, desk, edited

__all__ = ["desk"]

FORMAT = "format, convention, row, name, length_unit, angle_unit, gravity, base, tool, target, load, coupling, "

FAULTS = {
    "another format": (
        [('"elastocal-robot/1"', '"robot/2"')],
        ['format: expected "elastocal-robot/1", found "robot/2"'],
    ),
    "no format": (
        [('format = "elastocal-robot/1"\n', "")],
        ["'format' is missing: expected \"elastocal-robot/1\""],
    ),
    "a description of measurements": (
        [('"elastocal-robot/1"', '"elastocal-measurements/1"'), ("[tool]", "[columns]")],
        ['format: expected "elastocal-robot/1", found "elastocal-measurements/1": a description of measurements'],
    ),
    "another convention": (
        [('"modified-dh"', '"dh"')],
        ['convention: expected "modified-dh", "standard-dh" or "urdf", found "dh"'],
    ),
    "unknown units": (
        [('length_unit = "m"', 'length_unit = "inch"'), ('"rad"', '"grad"')],
        [
            'length_unit: expected "m" or "mm", found "inch"',
            'angle_unit: expected "rad" or "deg", found "grad"',
        ],
    ),
    "unknown keys": (
        [("alpha", "alfa"), ("[tool]", "[tol]"), ("mass = 3.0", "mas = 3.0")],
        [
            "row 2 (\"elbow\"): no key 'alfa'; did you mean 'alpha'? (valid: name, alpha, a, beta, b, theta, d, xyz, "
            "rpy, axis, joint, sign, limits, mass, com, stiffness)",
            "load.heavy: no key 'mas'; did you mean 'mass'? (valid: mass, com)",
            f"no key 'tol'; did you mean 'tool'? (valid: {FORMAT}elastic, transmission, station, tolerance)",
        ],
    ),
    "missing keys": (
        [('name = "elbow"\n', ""), ('convention = "modified-dh"\n', "")],
        [
            '\'convention\' is missing: expected "modified-dh", "standard-dh" or "urdf"',
            "row 2: 'name' is missing: expected a name in quotes",
        ],
    ),
    "wrong types": (
        [
            ("d = 0.4", 'd = "0.4"'),
            ('joint = "revolute"', 'joint = "rev"'),
            ("[-3.0, 3.0]", "[-3.0]"),
            ("mass = 5.0", "mass = true"),
            ("[0.0, 0.1, 0.0]", '[0.0, "a", 0.0]'),
            ("[1.0, 0.0, 0.0]", "[1.0, 0.0]\nknown = 1"),
        ],
        [
            'row 1, d: expected a number, found "0.4"',
            'row 1, joint: expected "revolute" or "prismatic", found "rev"',
            "row 1, limits: expected 2 numbers in brackets, found [-3.0]",
            'row 2 ("elbow"), mass: expected 0 or a positive number, found true',
            "tool.xyz: expected 3 numbers in brackets, found [0.0, 'a', 0.0]",
            "station.north.xyz: expected 3 numbers in brackets, found [1.0, 0.0]",
            "station.north.known: expected true or false, found 1",
        ],
    ),
    "a table where a number belongs, and the other way round": (
        [("d = 0.4", "d = { mm = 400 }"), ("[load.heavy]\nmass = 3.0", "[load]\nheavy = 3.0")],
        ["row 1, d: expected a number, found a table", "load.heavy: expected a table, found 3.0"],
    ),
    "numbers that are none": (
        [("0.4", "nan"), ("5.0", "inf"), ("[0.0, 0.1, 0.0]", "[0.0, nan, 0.0]")],
        [
            "row 1, d: expected a number, found nan",
            'row 2 ("elbow"), mass: expected 0 or a positive number, found inf',
            "tool.xyz: expected 3 numbers in brackets, found [0.0, nan, 0.0]",
        ],
    ),
    "two rows of one name": (
        [('"elbow"', '"1"')],
        ["rows 1 and 2 have the same name '1': names must differ"],
    ),
    "a reserved name": (
        [('"elbow"', '"tool"')],
        ['row 2 ("tool"): the names base, tool, target, station are taken: choose another'],
    ),
    "no joint": (
        [('joint = "revolute"\nlimits = [-3.0, 3.0]\n', ""), ('joint = "revolute"\n', "")],
        ['no row has a joint: write joint = "revolute" or "prismatic" in those that move'],
    ),
    "limits and stiffness without a joint": (
        [('joint = "revolute"\nlimits', "stiffness = 1e5\nlimits")],
        ['row 1 has limits and stiffness but no joint: expected joint = "revolute" or "prismatic"'],
    ),
    "negative masses": (
        [("mass = 5.0", "mass = -5.0"), ("mass = 3.0", "mass = -3")],
        [
            'row 2 ("elbow"), mass: expected 0 or a positive number, found -5.0',
            "load.heavy.mass: expected 0 or a positive number, found -3",
        ],
    ),
    "no stiffness at all": (
        [("mass = 5.0", "stiffness = 0.0")],
        ['row 2 ("elbow"), stiffness: expected a positive number, found 0.0'],
    ),
    "a sign that is none": (
        [("mass = 5.0", "sign = 2")],
        ['row 2 ("elbow"), sign: expected 1 or -1, found 2'],
    ),
    "reversed limits": (
        [("[-3.0, 3.0]", "[3.0, -3.0]")],
        ["row 1, limits: expected [lower, upper], found [3.0, -3.0]"],
    ),
    "keys of a URDF in a DH row": (
        [("alpha = 1.5", "xyz = [0.0, 0.0, 0.0]\naxis = [0.0, 0.0, 1.0]")],
        [
            f"row 2 (\"elbow\"): '{key}' is not of convention 'modified-dh' (valid: alpha, a, beta, b, theta, d)"
            for key in ("xyz", "axis")
        ],
    ),
    "keys of DH in a URDF row": (
        [('"modified-dh"', '"urdf"'), ("d = 0.4", "xyz = [0.0, 0.0, 0.4]")],
        [f"row 2 (\"elbow\"): '{key}' is not of convention 'urdf' (valid: xyz, rpy, axis)" for key in ("alpha", "a")],
    ),
    "an axis of no direction": (
        [('"modified-dh"', '"urdf"'), ("d = 0.4", "axis = [0.0, 0.0, 0.0]"), ("alpha = 1.5\na = 0.2\n", "")],
        ["row 1, axis: expected a direction, found zero length"],
    ),
}


@pytest.mark.parametrize("case", FAULTS)
def test_a_robot_file_with_faults_is_refused_and_each_is_told(desk: Desk, case: str):
    edits, faults = FAULTS[case]
    desk.write(robot_toml=edited(ROBOT, *edits), fit_csv=TABLE)
    assert desk.refused("validate robot.toml fit.csv -o out/residuals.csv") == [f"robot.toml: {f}" for f in faults]


@pytest.mark.parametrize("command", ["calibrate robot.toml fit.csv -o out", "validate robot.toml fit.csv --json"])
def test_faults_of_every_kind_are_told_at_once(desk: Desk, command: str):
    text = edited(ROBOT, ("d = 0.4", 'd = "0.4"'), ("1.5", "90"), ("0.1, 0.0]", "612, 0.0]"), ("mass = 3.0", "mas = 3"))
    desk.write(robot_toml=text + '[elastic."1.theta"]\nlaw = "springy"\ncoefficients = [1e-6]\n', fit_csv=TABLE)
    faults = desk.refused(command)
    for place in ("row 1, d", 'row 2 ("elbow"), alpha', "tool.xyz", "load.heavy", 'elastic."1.theta".law'):
        assert sum(fault.startswith(f"robot.toml: {place}: ") for fault in faults) == 1
    assert len(faults) == 5


def test_what_follows_from_a_fault_alone_is_not_told(desk: Desk):
    desk.write(robot_toml=edited(ROBOT, ('joint = "revolute"', 'joint = "rev"'), ('"rad"', '"turn"')), fit_csv=TABLE)
    assert len(desk.refused("validate robot.toml fit.csv")) == 2


def test_a_file_that_is_not_toml_is_refused_with_line_and_column(desk: Desk):
    desk.write(robot_toml=edited(ROBOT, ("d = 0.4", "d = 0,4")), fit_csv=TABLE)
    (fault,) = desk.refused("validate robot.toml fit.csv")
    assert fault.startswith("robot.toml: not valid TOML: ")
    assert "line 9, column 6" in fault


def test_a_file_in_another_encoding_is_refused_with_the_line(desk: Desk):
    desk.write(robot_toml=edited(ROBOT, ('"arm"', '"ärm"')).encode("latin-1"), fit_csv=TABLE)
    expected = "robot.toml: expected UTF-8 text, found byte 0xe4 in line 2: save it as UTF-8"
    assert desk.refused("validate robot.toml fit.csv") == [expected]


def test_a_byte_order_mark_does_no_harm(desk: Desk):
    desk.write(robot_toml=ROBOT.encode("utf-8-sig"), fit_csv=TABLE)
    desk.done("validate robot.toml fit.csv")


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("robots.toml", "robots.toml: no such file; did you mean robot.toml? (there: robot.toml)"),
        ("nowhere/robot.toml", "nowhere/robot.toml: no such file: there is no folder nowhere"),
        ("fit.csv", "fit.csv: expected a robot file (.toml) or a URDF (.urdf), found .csv"),
        (".", ".: expected a file, found a folder"),
        ("r" * 300 + ".toml", "r" * 300 + ".toml: cannot be read: file name too long"),
    ],
)
def test_a_file_that_is_not_there_is_refused_and_what_is_there_told(desk: Desk, name: str, fault: str):
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    assert desk.refused(f"validate {name} fit.csv -o residuals.csv") == [fault]


def test_a_robot_file_has_no_tip(desk: Desk):
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    expected = "robot.toml: --tip is for a URDF; a robot file has one chain"
    assert desk.refused("validate robot.toml fit.csv --tip elbow") == [expected]
