"""Values of a robot file that cannot be meant: units taken for others, couplings, elements and laws."""

from __future__ import annotations

import pytest

from support.files import ROBOT, TABLE, Desk, desk, edited

__all__ = ["desk"]

COMPLIANT = '\n[elastic."{}"]\nlaw = "{}"\ncoefficients = {}\n'

UNITS = {
    "degrees in a file of radians": (
        [("1.5", "90"), ("[-3.0, 3.0]", "[-180, 180]"), ("[1.0, 0.0, 0.0]", "[1.0, 0.0, 0.0]\nrpy = [0, 0, 180]")],
        [
            'row 1, limits: -180 rad is 28.6 turns: is angle_unit = "deg" meant?',
            'row 2 ("elbow"), alpha: 90 rad is 14.3 turns: is angle_unit = "deg" meant?',
            'station.north.rpy: 180 rad is 28.6 turns: is angle_unit = "deg" meant?',
        ],
    ),
    "millimetres in a file of metres": (
        [
            ("0.4", "400"),
            ("0.2", "612"),
            ("[0.0, 0.1, 0.0]", "[0, 100, 0]"),
            ("3.0\n\n[st", "3.0\ncom = [0, 0, 90]\n[st"),
        ],
        [
            'row 1, d: 400 m is longer than any robot: is length_unit = "mm" meant?',
            'row 2 ("elbow"), a: 612 m is longer than any robot: is length_unit = "mm" meant?',
            'tool.xyz: 100 m is longer than any robot: is length_unit = "mm" meant?',
            'load.heavy.com: 90 m is longer than any robot: is length_unit = "mm" meant?',
        ],
    ),
    "a stroke in millimetres in a file of metres": (
        [('joint = "revolute"', 'joint = "prismatic"'), ("[-3.0, 3.0]", "[0, 800]")],
        ['row 1, limits: 800 m is longer than any robot: is length_unit = "mm" meant?'],
    ),
    "lengths beyond reason in a file of millimetres": (
        [('length_unit = "m"', 'length_unit = "mm"'), ("0.2", "612000")],
        ['row 2 ("elbow"), a: 612000 mm is longer than any robot'],
    ),
    "degrees and lengths in a URDF row": (
        [
            ('"modified-dh"', '"urdf"'),
            ("d = 0.4", "xyz = [0, 0, 400]\nrpy = [0, 90, 0]"),
            ("alpha = 1.5\na = 0.2\n", ""),
        ],
        [
            'row 1, xyz: 400 m is longer than any robot: is length_unit = "mm" meant?',
            'row 1, rpy: 90 rad is 14.3 turns: is angle_unit = "deg" meant?',
        ],
    ),
}

ADDED = {
    "too few lines of coupling": (
        "[coupling]\nmatrix = [[1, 0]]",
        ["coupling.matrix: expected 2 lines, one for each joint, found 1"],
    ),
    "uneven lines of coupling": (
        "[coupling]\nmatrix = [[1, 0, 0], [0, 1]]",
        [
            "coupling.matrix: expected lines of equal length, one number for each controller joint, found 3 and 2",
        ],
    ),
    "a flat coupling": (
        "[coupling]\nmatrix = [1, 0]",
        ["coupling.matrix: expected lines of numbers, as [[1, 0], [0, 1]], found [1, 0]"],
    ),
    "an empty coupling": (
        "[coupling]",
        ["coupling: 'matrix' is missing: expected lines of numbers, as [[1, 0], [0, 1]]"],
    ),
    "a row instead of an element": (
        COMPLIANT.format("elbow", "linear", "[1e-6]"),
        ["elastic: no element 'elbow'; did you mean 'elbow.theta', which the joint drives?"],
    ),
    "an element misspelt": (
        COMPLIANT.format("elbow.theat", "linear", "[1e-6]"),
        [
            "elastic: no element 'elbow.theat'; did you mean 'elbow.theta'? (valid: elbow.alpha, elbow.a, elbow.beta, "
            "elbow.b, elbow.theta, elbow.d)"
        ],
    ),
    "an element of a frame, which cannot give way": (
        COMPLIANT.format("tool.rx", "linear", "[1e-6]"),
        [
            "elastic: no element 'tool.rx' (valid: 1.alpha, 1.a, 1.beta, 1.b, 1.theta, 1.d, elbow.alpha, elbow.a, "
            "elbow.beta, elbow.b, elbow.theta, elbow.d)"
        ],
    ),
    "too many coefficients": (
        COMPLIANT.format("elbow.theta", "linear", "[1e-6, 2e-6]"),
        ["elastic.\"elbow.theta\".coefficients: expected [c] of law 'linear', found 2 numbers"],
    ),
    "a transition torque that the law has not": (
        COMPLIANT.format("elbow.theta", "linear", "[1e-6]\ntransition_torque = 20.0"),
        ["elastic.\"elbow.theta\".transition_torque: law 'linear' has none: leave it out"],
    ),
    "coefficients that are none": (
        COMPLIANT.format("elbow.theta", "linear", "[nan]"),
        ['elastic."elbow.theta".coefficients: expected numbers in brackets, found [nan]'],
    ),
    "a transmission error of what no joint drives": (
        '[transmission."elbow.alpha"]\nsin = [1e-4]',
        ["transmission: no driven element 'elbow.alpha'; did you mean 'elbow.theta'? (valid: elbow.theta)"],
    ),
    "a transmission error of a row that is not there": (
        '[transmission."2.theta"]\nsin = [1e-4]',
        ["transmission: no driven element '2.theta'; did you mean '1.theta'? (valid: 1.theta, elbow.theta)"],
    ),
}


@pytest.mark.parametrize("case", UNITS)
def test_units_taken_for_others_are_told(desk: Desk, case: str):
    edits, faults = UNITS[case]
    desk.write(robot_toml=edited(ROBOT, *edits), fit_csv=TABLE)
    assert desk.refused("validate robot.toml fit.csv") == [f"robot.toml: {fault}" for fault in faults]


@pytest.mark.parametrize("case", ADDED)
def test_couplings_elements_and_laws_that_do_not_fit_are_told(desk: Desk, case: str):
    added, faults = ADDED[case]
    desk.write(robot_toml=f"{ROBOT}{added}\n", fit_csv=TABLE)
    assert desk.refused("validate robot.toml fit.csv") == [f"robot.toml: {fault}" for fault in faults]


def test_a_law_misspelt_is_told_with_those_that_exist(desk: Desk):
    desk.write(robot_toml=ROBOT + COMPLIANT.format("elbow.theta", "liner", "[1e-6]"), fit_csv=TABLE)
    (fault,) = desk.refused("validate robot.toml fit.csv")
    assert fault.startswith(
        "robot.toml: elastic.\"elbow.theta\".law: no law 'liner'; did you mean 'linear'? (valid: linear"
    )
