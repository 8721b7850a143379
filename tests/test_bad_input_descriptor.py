"""Faults of a descriptor, and of the instrument's own file that it describes."""

from __future__ import annotations

import pytest

from support.files import DESCRIPTOR, ROBOT, TRACKER, Desk, desk, edited

__all__ = ["desk"]

HAS = "tracker.csv has no column"
COLUMNS = "(valid: shoulder, wrist, mx, my, mz, rx, ry, rz, std, probe)"
CONVENTIONS = (
    "(valid: euler-XYZ, euler-xyz, euler-ZYX, euler-zyx, euler-ZYZ, euler-zyz, quaternion-wxyz, quaternion-xyzw, "
    "rotation-vector, matrix)"
)
ANGLES = "(valid: rad, deg, mrad, °)"

FAULTS = {
    "unknown keys": (
        [("decimal", "decimel"), ('unit = "deg" }', 'units = "deg" }'), ("position", "postion")],
        [
            "columns.q: no key 'units'; did you mean 'unit'? (valid: columns, unit, convention)",
            "columns: no key 'postion'; did you mean 'position'? (valid: q, position, orientation, distance, sigma, "
            "sigma_angle, force, moment, temperature, target, load, station, pose)",
            "no key 'decimel'; did you mean 'decimal'? (valid: format, file, columns, delimiter, decimal, skip)",
        ],
    ),
    "a robot file": (
        [("elastocal-measurements/1", "elastocal-robot/1"), ("[columns]", "[tool]")],
        ['format: expected "elastocal-measurements/1", found "elastocal-robot/1": a robot file'],
    ),
    "missing keys": (
        [('file = "tracker.csv"\n', ""), ("q = {", "j = {")],
        [
            "'file' is missing: expected text in quotes",
            "columns: 'q' is missing: expected a table",
            "columns: no key 'j' (valid: q, position, orientation, distance, sigma, sigma_angle, force, moment, "
            "temperature, target, load, station, pose)",
        ],
    ),
    "wrong types": (
        [
            ('delimiter = ";"', 'delimiter = ";;"\nskip = -1'),
            ('decimal = ","', 'decimal = "x"'),
            ('["mx", "my", "mz"]', '"mx"'),
        ],
        [
            'columns.position.columns: expected names in quotes, in brackets, found "mx"',
            'delimiter: expected one character in quotes, found ";;"',
            'decimal: expected "." or ",", found "x"',
            "skip: expected a whole number, 0 or more, found -1",
        ],
    ),
    "columns that are not there": (
        [('"wrist"', '"wirst"'), ('"mx"', '"mxx"')],
        [
            f"columns.q: {HAS} 'wirst'; did you mean 'wrist'? {COLUMNS}",
            f"columns.position: {HAS} 'mxx'; did you mean 'mx'? {COLUMNS}",
        ],
    ),
    "wrong numbers of columns": (
        [(', "wrist"', ""), ('"mx", ', ""), ('"rx", ', "")],
        [
            "columns.position: expected 3 columns, found 2",
            "columns.q: expected 2 columns for the joints of arm, found 1",
            "columns.orientation: expected 3 columns for euler-XYZ, found 2",
        ],
    ),
    "a column named twice": (
        [('"shoulder", "wrist"', '"wrist", "wrist"')],
        ["columns.q: column 'wrist' is named twice"],
    ),
    "units that do not exist": (
        [
            ('"wrist"], unit = "deg"', '"wrist"], unit = "mm"'),
            ('unit = "mm" }\nor', 'unit = "inch" }\nor'),
            ('unit = "deg", c', 'unit = "m", c'),
        ],
        [
            "columns.position.unit: no length unit 'inch'; did you mean 'in'? (valid: m, mm, cm, um, µm, μm, in)",
            f"columns.q.unit: no angle unit 'mm' {ANGLES}",
            f"columns.orientation.unit: no angle unit 'm' {ANGLES}",
        ],
    ),
    "Euler angles of neighbours that are the same": (
        [("euler-XYZ", "euler-XXY")],
        [f"columns.orientation.convention: no convention 'euler-XXY'; did you mean 'euler-XYZ'? {CONVENTIONS}"],
    ),
    "Euler angles both intrinsic and extrinsic": (
        [("euler-XYZ", "euler-xYz")],
        [f"columns.orientation.convention: no convention 'euler-xYz'; did you mean 'euler-xyz'? {CONVENTIONS}"],
    ),
    "no convention": (
        [(', convention = "euler-XYZ"', "")],
        [f"columns.orientation: 'convention' is missing: expected one of {CONVENTIONS[8:-1]}"],
    ),
    "a unit of what has none": (
        [("euler-XYZ", "quaternion-wxyz"), ('"rx", "ry"', '"std", "rx", "ry"')],
        ["columns.orientation.unit: quaternion-wxyz has none: leave it out"],
    ),
    "a convention of what has none": (
        [('unit = "mm" }\nor', 'unit = "mm", convention = "xyz" }\nor')],
        ["columns.position: only an orientation has a convention: leave it out"],
    ),
    "nothing measured": (
        [("position =", "force ="), ('"mm"', '"N"'), ("\norientation", "\n# orientation")],
        ["columns: expected something measured: position, orientation and/or distance, found none"],
    ),
    "a column and a value": (
        [("[columns]\n", '[columns]\ntarget = { column = "probe", value = "a" }\nload = {}\n')],
        [
            "columns.target: expected a column or a value for all rows, found both",
            "columns.load: expected a column or a value for all rows, found neither",
        ],
    ),
}

ROWS = {
    "a decimal point": (
        [("10,5", "10.5")],
        [],
        ["row 1, column 'shoulder': expected a number with a decimal comma, found '10.5'"],
    ),
    "a decimal comma": (
        [],
        [('decimal = ","\n', "")],
        [
            f"row 1, column '{column}': expected a number with a decimal point (for decimal commas write in "
            f"tracker.toml decimal = \",\"), found '{found}' (and 1 more row)"
            for column, found in (("shoulder", "10,5"), ("mx", "100,5"))
        ],
    ),
    "another delimiter": (
        [],
        [('delimiter = ";"\n', "")],
        [
            'expected "," between columns, found ";" in the header "shoulder;wrist;mx;my;mz;rx;ry;rz;std;pro": '
            'write in tracker.toml delimiter = ";"'
        ],
    ),
    "degrees taken for radians": (
        [],
        [('"wrist"], unit = "deg"', '"wrist"]')],
        [
            "row 1, column 'shoulder': expected joint 1 within its limits -3 … 3 rad (for degrees write unit = "
            '"deg" in tracker.toml), found 10.5 (and 1 more row)',
            "row 1, column 'wrist': expected a joint position in rad (for degrees write unit = \"deg\" in "
            "tracker.toml), found 20 (and 1 more row)",
        ],
    ),
    "millimetres taken for metres": (
        [("101,5", "1101,5"), *((str(n), "0,2") for n in (200, 201, 300, 301))],
        [(', unit = "mm"', "")],
        [
            "row 2, column 'mx': expected at most 200 m (for millimetres write unit = \"mm\" in tracker.toml), "
            "found 1101.5 m"
        ],
    ),
    "an orientation that is no rotation": (
        [("10;20;30;0,1", "1;1;0;1"), ("11;21;31;0,1", "1;0;0;0")],
        [("euler-XYZ", "quaternion-wxyz"), ('unit = "deg", ', ""), ('"rz"]', '"rz", "std"]')],
        ["row 1, column 'rx, ry, rz, std': expected a quaternion, length 1, found length 1.73"],
    ),
    "rows of another length": (
        [("21;101,5;201", "21;101,5")],
        [],
        ["row 2: expected 10 fields as in the header, found 9"],
    ),
}


@pytest.mark.parametrize("case", FAULTS)
def test_a_descriptor_with_faults_is_refused_and_each_is_told(desk: Desk, case: str):
    edits, faults = FAULTS[case]
    desk.write(robot_toml=ROBOT, tracker_csv=TRACKER, tracker_toml=edited(DESCRIPTOR, *edits))
    assert desk.refused("validate robot.toml tracker.toml -o out.csv") == [f"tracker.toml: {f}" for f in faults]


@pytest.mark.parametrize("case", ROWS)
def test_rows_that_do_not_fit_the_descriptor_are_told_by_their_own_headers(desk: Desk, case: str):
    cells, edits, faults = ROWS[case]
    desk.write(robot_toml=ROBOT, tracker_csv=edited(TRACKER, *cells), tracker_toml=edited(DESCRIPTOR, *edits))
    assert desk.refused("validate robot.toml tracker.toml") == [f"tracker.csv: {fault}" for fault in faults]


def test_columns_of_one_name_are_told_where_they_are_asked_for(desk: Desk):
    desk.write(robot_toml=ROBOT, tracker_csv=edited(TRACKER, ("my", "mx")), tracker_toml=DESCRIPTOR)
    faults = desk.refused("validate robot.toml tracker.toml")
    assert faults[0] == "tracker.toml: columns.position: tracker.csv has several columns 'mx': expected one"


@pytest.mark.parametrize(
    ("matrix", "found"), [("1 0 0 0 1 0 0 0 2", "R·Rᵀ off by 3"), ("1 0 0 0 1 0 0 0 -1", "a mirrored one")]
)
def test_a_matrix_that_is_no_rotation_is_told(desk: Desk, matrix: str, found: str):
    header = " ".join(f"r{i}" for i in range(9))
    described = edited(
        DESCRIPTOR,
        ('";"', '" "'),
        ('["rx", "ry", "rz"], unit = "deg", convention = "euler-XYZ"', f'{header.split()}, convention = "matrix"'),
    )
    desk.write(
        robot_toml=ROBOT, tracker_toml=described, tracker_csv=f"shoulder wrist mx my mz {header}\n1 2 3 4 5 {matrix}\n"
    )
    expected = f"tracker.csv: row 1, column '{header.replace(' ', ', ')}': expected a rotation matrix, found {found}"
    assert desk.refused("validate robot.toml tracker.toml") == [expected]


def test_a_file_that_is_not_there_is_looked_for_beside_the_descriptor(desk: Desk):
    (desk.folder / "data").mkdir()
    (desk.folder / "data" / "tracker.toml").write_text(DESCRIPTOR)
    desk.write(robot_toml=ROBOT, tracker_csv=TRACKER)
    assert desk.refused("validate robot.toml data/tracker.toml") == ["data/tracker.csv: no such file"]


def test_a_joint_that_slides_and_one_that_turns_have_no_common_unit(desk: Desk):
    slide = edited(ROBOT, ('joint = "revolute"', 'joint = "prismatic"'), ("[-3.0, 3.0]", "[0.0, 0.8]"))
    desk.write(robot_toml=slide, tracker_csv=TRACKER, tracker_toml=DESCRIPTOR)
    expected = (
        "tracker.toml: columns.q.unit: arm has joints that turn and joints that slide: leave it out, give rad and m"
    )
    assert desk.refused("validate robot.toml tracker.toml") == [expected]
