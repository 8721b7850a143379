"""Faults in the rows and headers of a measurement table."""

from __future__ import annotations

import pytest

from support.files import ROBOT, TABLE, Desk, desk, edited

__all__ = ["desk"]

HEADER, FIRST, SECOND, THIRD = TABLE.splitlines()
VALID = (
    "(valid: q1, q2, x, y, z, distance, sigma, qw, qx, qy, qz, sigma_angle, wrench_fx, wrench_fy, wrench_fz, "
    "wrench_mx, wrench_my, wrench_mz, temperature, target, load, station, pose)"
)
JOINTS = "expected the columns q1 … q2 of the 2 joints of arm"
LIMITS = "expected joint 1 within its limits"
COMMA = 'a number with a decimal point (for decimal commas describe the file by a TOML with decimal = ",")'
EXPORT = (
    'decimal commas? export them with ";" between columns, described by a TOML with delimiter = ";" and decimal = ","'
)


def with_column(header: str, *cells: str) -> str:
    """The table with one more column."""
    return "".join(f"{line},{cell}\n" for line, cell in zip(TABLE.splitlines(), [header, *cells], strict=True))


HEADERS = {
    "too few joints": (f"{HEADER[9:]}\n20,100,200,300\n", [f"{JOINTS}: q1 missing"]),
    "too many joints": (with_column("q3 [deg]", "1", "2", "3"), [f"{JOINTS}: 'q3 [deg]' too many"]),
    "joints of other names": (TABLE.replace("q", "j"), [f"{JOINTS}: found none of them"]),
    "headers in another style": (
        "q1 (deg),Q2_deg,X,y_mm,z mm\n10,20,0.1,200,300\n",
        [
            "column 'q1 (deg)': expected the header 'q1 [deg]'",
            "column 'Q2_deg': expected the header 'q2 [deg]'",
            "column 'X': expected the header 'x'",
            "column 'y_mm': expected the header 'y [mm]'",
            "column 'z mm': expected the header 'z [mm]'",
        ],
    ),
    "misspelt columns": (
        with_column("taget", "a", "a", "a"),
        [f"no column 'taget'; did you mean 'target'? {VALID}"],
    ),
    "the same column twice": (
        with_column("z [mm]", "1", "2", "3"),
        ["column 'z [mm]' is there 2 times: leave all but one out"],
    ),
    "the same column in two units": (
        with_column("z", "1", "2", "3"),
        ["columns 'z [mm]' and 'z' say the same: leave one out"],
    ),
    "units of other quantities and none at all": (
        edited(TABLE, ("q1 [deg]", "q1 [mm]"), ("x [mm]", "x [inch]"), ("y [mm]", "y [deg]")),
        [
            "column 'q1 [mm]': no angle unit 'mm' (valid: rad, deg, mrad, °)",
            "column 'x [inch]': no length unit 'inch'; did you mean 'in'? (valid: m, mm, cm, um, µm, μm, in)",
            "column 'y [deg]': no length unit 'deg' (valid: m, mm, cm, um, µm, μm, in)",
        ],
    ),
    "a quaternion with a unit": (
        f"{HEADER},qw [mm],qx,qy,qz\n{FIRST},1,0,0,0\n",
        ["column 'qw [mm]': expected no unit, found 'mm'"],
    ),
    "x without y": (
        f"{HEADER.replace(',y [mm]', '')}\n10,20,100,300\n",
        ["expected the columns x, y, z, or none of them: y missing"],
    ),
    "nothing measured": (
        "q1,q2\n0.1,0.2\n",
        ["expected something measured: columns x, y, z and/or qw, qx, qy, qz and/or distance, found none"],
    ),
    "semicolons": (
        TABLE.replace(",", ";"),
        [
            'expected "," between columns, found ";" in the header "q1 [deg];q2 [deg];x [mm];y [mm];z [mm]": describe '
            'the file by a TOML with delimiter = ";"'
        ],
    ),
    "tabs": (
        TABLE.replace(",", "\t"),
        [
            r'expected "," between columns, found "\t" in the header "q1 [deg]\tq2 [deg]\tx [mm]\ty [mm]\tz [mm]": '
            r'describe the file by a TOML with delimiter = "\t"'
        ],
    ),
    "no rows": (f"{HEADER}\n", ["expected at least one row of measurements, found none"]),
    "nothing at all": ("", ["expected a header and rows, found an empty file"]),
    "empty lines only": ("\r\n\n", ["expected a header and rows, found an empty file"]),
}

CELLS = {
    "text for numbers": (
        edited(TABLE, ("101", "n/a"), ("12,", "x,")),
        [
            "row 3, column 'q1 [deg]': expected a number, found 'x'",
            "row 2, column 'x [mm]': expected a number, found 'n/a'",
        ],
    ),
    "numbers that are none": (
        edited(TABLE, ("101", "nan"), ("12,", "inf,")),
        [
            "row 3, column 'q1 [deg]': expected a number, found 'inf'",
            "row 2, column 'x [mm]': expected a number, found 'nan'",
        ],
    ),
    "empty cells": (
        edited(TABLE, ("101", ""), ("102", " "), ("12,", ",")),
        [
            "row 3, column 'q1 [deg]': expected a number, found an empty cell",
            "row 2, column 'x [mm]': expected a number, found an empty cell (and 1 more row)",
        ],
    ),
    "an empty line": (
        f"{HEADER}\n{FIRST}\n\n,,,,\n{SECOND}\n\n",
        ["row 2: expected measurements, found none (and 1 more row)"],
    ),
    "rows too short": (
        edited(TABLE, (",301", ""), (",302", "")),
        ["row 2: expected 5 fields as in the header, found 4 (and 1 more row)"],
    ),
    "a decimal comma that is a field": (
        edited(TABLE, ("101", "101,5")),
        [f"row 2: expected 5 fields as in the header, found 6; {EXPORT}"],
    ),
    "a decimal comma in quotes": (
        edited(TABLE, ("101", '"101,5"')),
        [f"row 2, column 'x [mm]': expected {COMMA}, found '101,5'"],
    ),
    "degrees in columns of radians": (
        TABLE.replace(" [deg]", ""),
        [
            f"row 1, column 'q1': {LIMITS} -3 … 3 rad (for degrees write the header 'q1 [deg]'), found 10 (and 2 more "
            "rows)",
            "row 1, column 'q2': expected a joint position in rad (for degrees write the header 'q2 [deg]'), found 20 "
            "(and 2 more rows)",
        ],
    ),
    "a joint out of its limits": (
        edited(TABLE, ("10,", "179,"), ("11,", "-175,")),
        [f"row 1, column 'q1 [deg]': {LIMITS} -171.887 … 171.887 deg, found 179 (and 1 more row)"],
    ),
    "a joint without limits that turns too far": (
        edited(TABLE, (",21,", ",4000,")),
        ["row 2, column 'q2 [deg]': expected a joint position in deg, found 4000"],
    ),
    "millimetres in columns of metres": (
        edited(TABLE, ("x [mm]", "x"), (",100,", ",1200,"), (",101,", ",0.1,"), (",102,", ",1,")),
        ["row 1, column 'x': expected at most 200 m (for millimetres write the header 'x [mm]'), found 1200 m"],
    ),
    "copied rows": (
        f"{TABLE}{FIRST}\n{SECOND}\n",
        ["row 4 is a copy of row 1, to the last digit (and 1 more copied row): leave it out"],
    ),
    "a quaternion that is none": (
        f"{HEADER},qw,qx,qy,qz\n{FIRST},1,1,0,0\n{SECOND},0,0,0,0\n{THIRD},0,1,0,0\n",
        ["row 1, column 'qw, qx, qy, qz': expected a quaternion, length 1, found length 1.41 (and 1 more row)"],
    ),
    "a sigma of zero": (
        with_column("sigma [mm]", "0.1", "0", "-1"),
        ["row 2, column 'sigma [mm]': expected a positive number, found 0 (and 1 more row)"],
    ),
    "a negative sigma of the angle": (
        with_column("sigma_angle [mrad]", "1", "1", "-1"),
        ["row 3, column 'sigma_angle [mrad]': expected a positive number, found -1"],
    ),
    "a distance of zero": (
        "q1,q2,distance [mm]\n0.1,0.2,0\n",
        ["row 1, column 'distance [mm]': expected a positive number, found 0"],
    ),
    "names that the robot does not have": (
        f"{HEADER},target,load,station\n{FIRST},nest,hevy,south\n{SECOND},nest,heavy,north\n",
        [
            "row 1, column 'target': arm has no target 'nest' (valid: none) (and 1 more row)",
            "row 1, column 'load': arm has no load 'hevy'; did you mean 'heavy'? (valid: heavy)",
            "row 1, column 'station': arm has no station 'south'; did you mean 'north'? (valid: north)",
        ],
    ),
    "faults of all kinds": (
        edited(TABLE, ("101", "n/a"), ("10,", "179,")) + f"{THIRD}\n",
        [
            "row 2, column 'x [mm]': expected a number, found 'n/a'",
            f"row 1, column 'q1 [deg]': {LIMITS} -171.887 … 171.887 deg, found 179",
            "row 4 is a copy of row 3, to the last digit: leave it out",
        ],
    ),
}

TWO_TARGETS = f"{ROBOT}[target.near]\n[target.far]\nxyz = [0.2, 0.0, 0.0]\n"


@pytest.mark.parametrize("case", HEADERS)
def test_a_table_with_wrong_columns_is_refused_and_each_fault_told(desk: Desk, case: str):
    text, faults = HEADERS[case]
    desk.write(robot_toml=ROBOT, fit_csv=text)
    assert desk.refused("validate robot.toml fit.csv -o out/residuals.csv") == [f"fit.csv: {f}" for f in faults]


@pytest.mark.parametrize("case", CELLS)
def test_a_table_with_wrong_rows_is_refused_and_each_fault_told(desk: Desk, case: str):
    text, faults = CELLS[case]
    desk.write(robot_toml=ROBOT, fit_csv=text)
    assert desk.refused("validate robot.toml fit.csv -o out/residuals.csv") == [f"fit.csv: {f}" for f in faults]


def test_faults_of_data_stop_a_calibration_too(desk: Desk):
    text, faults = CELLS["faults of all kinds"]
    desk.write(robot_toml=ROBOT, fit_csv=TABLE, held_csv=text)
    assert desk.refused("calibrate robot.toml fit.csv --held-out held.csv -o out --json") == [
        f"held.csv: {fault}" for fault in faults
    ]


def test_of_many_faults_the_first_are_told_and_the_rest_counted(desk: Desk):
    others = ",".join(f"q{i} [grad]" for i in range(1, 31))
    rows = "".join(f'[[row]]\nname = "{i}"\njoint = "revolute"\n' for i in range(1, 31))
    head = 'format = "elastocal-robot/1"\nconvention = "modified-dh"\n'
    desk.write(robot_toml=head + rows, fit_csv=f"{others},x,y,z\n{'0,' * 30}1,2,3\n")
    faults = desk.refused("validate robot.toml fit.csv")
    assert faults[-1] == "fit.csv: and 10 more faults"
    assert len(faults) == 21


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (f"{TABLE}", "expected a column 'target' with one of near, far, found none"),
        (
            with_column("target", "near", "", "far"),
            "row 2, column 'target': expected one of near, far, found an empty cell",
        ),
        (
            with_column("target", "near", "fare", "far"),
            "row 2, column 'target': arm has no target 'fare'; did you mean 'far'? (valid: near, far)",
        ),
    ],
)
def test_a_robot_with_several_targets_asks_for_one_in_each_row(desk: Desk, text: str, fault: str):
    desk.write(robot_toml=TWO_TARGETS, fit_csv=text)
    assert desk.refused("validate robot.toml fit.csv") == [f"fit.csv: {fault}"]


def test_millimetres_of_a_slide_in_a_column_of_metres_are_told(desk: Desk):
    slide = edited(ROBOT, ('joint = "revolute"', 'joint = "prismatic"'), ("[-3.0, 3.0]", "[0.0, 0.8]"))
    desk.write(robot_toml=slide, fit_csv=edited(TABLE, ("q1 [deg]", "q1")))
    expected = (
        "fit.csv: row 1, column 'q1': expected joint 1 within its limits 0 … 0.8 m (for millimetres write the header "
        "'q1 [mm]'), found 10 (and 2 more rows)"
    )
    assert desk.refused("validate robot.toml fit.csv") == [expected]


def test_columns_that_the_format_does_not_know_are_left_alone(desk: Desk):
    desk.write(robot_toml=ROBOT, fit_csv=with_column("remark [!]", "good", "", "n/a"))
    desk.done("validate robot.toml fit.csv")
