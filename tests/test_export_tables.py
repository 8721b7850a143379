"""DH tables, UR's kinematics file and corrections, read back by readers that know nothing of elastocal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import InputError
from elastocal.io.exports import Exported
from elastocal.robot import DH_KEYS, Robot
from support.exports import CONVENTIONS, at_its_base, pose_of_table, pose_of_ur, random_robot, softened, table
from support.files import flawed
from support.robots import arm
from support.urdf import frame_matrix

TABLES = {"dh-csv": False, "mdh-csv": True}


def assert_left(robot: Robot, exported: Exported, read: np.ndarray, q: np.ndarray, reading: str) -> None:
    """The stated residuals are those between the robot and what was read, poses (n, 4, 4), at these other poses."""
    for residual in exported.residuals:
        if residual.refitted or residual.reading != reading:
            continue
        real = ec.predict(at_its_base(robot), q, load=residual.load)[0]
        left = np.linalg.norm(real - read[:, :3, 3], axis=1)
        assert residual.position.mean() == pytest.approx(left.mean(), rel=0.1)
        assert residual.position.mean() > 1e-5


@pytest.mark.parametrize("to", TABLES)
@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("seed", range(3))
def test_a_textbook_reader_of_a_table_has_the_rigid_robot(seed: int, convention: str, to: str):
    robot = random_robot(np.random.default_rng(seed), convention)
    q = ec.random_poses(robot, 10, 3)
    text = ec.export_robot(robot, to).text
    position, rotation = ec.predict(at_its_base(robot), q)
    for k, pose in enumerate(q):
        found = pose_of_table(text, TABLES[to], pose)
        np.testing.assert_allclose(found[:3, 3], position[k], rtol=0, atol=1e-9)
        np.testing.assert_allclose(found[:3, :3], rotation[k], rtol=0, atol=1e-9)


@pytest.mark.parametrize("to", TABLES)
def test_the_residual_of_a_table_is_what_its_reader_finds(to: str):
    robot = softened(flawed(arm(), np.random.default_rng(4)))
    exported = ec.export_robot(robot, to)
    assert any("Axes 2 and 3 are nearly parallel" in note for note in exported.notes)
    q = ec.random_poses(robot, 1500, 99)
    read = np.array([pose_of_table(exported.text, TABLES[to], pose) for pose in q])
    assert_left(robot, exported, read, q, "the table")


def test_a_table_with_far_normals_has_no_tilt_to_tell():
    robot = flawed(arm(), np.random.default_rng(4))
    exported = ec.export_robot(robot, "dh-csv", longest=1e5)
    assert not any("nearly parallel" in note for note in exported.notes)
    assert max(residual.position.max() for residual in exported.residuals) < 1e-9
    q = ec.random_poses(robot, 10, 3)
    position = ec.predict(at_its_base(robot), q)[0]
    found = np.array([pose_of_table(exported.text, False, pose)[:3, 3] for pose in q])
    np.testing.assert_allclose(found, position, rtol=0, atol=1e-7)  # millidegrees are written to 1e-6


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("seed", range(3))
def test_ur_description_puts_wrist_3_where_the_last_joint_is(seed: int, convention: str):
    robot = random_robot(np.random.default_rng(seed), convention, prismatic=0.0)
    q = ec.random_poses(robot, 10, 3)
    exported = ec.export_robot(robot, "ur-yaml")
    position, rotation = ec.predict(at_its_base(robot), q)
    found = np.array([pose_of_ur(exported.text, pose) for pose in q])
    # the tool stands still in wrist_3, where the file's sentence says
    tool = np.linalg.inv(found[0]) @ frame_matrix(replace(robot.tool, xyz=(0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.0)))
    tool = tool @ np.block([[rotation[0], position[0][:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])
    np.testing.assert_allclose((found @ tool)[:, :3, 3], position, rtol=0, atol=1e-12)
    np.testing.assert_allclose((found @ tool)[:, :3, :3], rotation, rtol=0, atol=1e-12)
    told = next(text for text in exported.cannot_hold if text.startswith("tool: from wrist_3 (tool0)"))
    numbers = told.split("xyz ")[1].split(" mm")[0]
    np.testing.assert_allclose(np.array(numbers.split(), dtype=float), 1e3 * tool[:3, 3], rtol=0, atol=1e-6)


def test_an_arm_like_urs_has_no_tool_to_tell_and_the_usual_numbers():
    table = ((0.1273, 0.0, 90.0), (0.0, -0.612, 0.0), (0.0, -0.5723, 0.0))
    table += ((0.163941, 0.0, 90.0), (0.1157, 0.0, -90.0), (0.0922, 0.0, 0.0))
    rows = tuple(
        replace(row, geometry={"d": d, "a": a, "alpha": np.deg2rad(alpha)})
        for row, (d, a, alpha) in zip(arm().rows, table, strict=True)
    )
    exported = ec.export_robot(replace(arm(), convention="standard-dh", rows=rows), "ur-yaml")
    assert not any(text.startswith("tool") for text in exported.cannot_hold)
    lines = [line.strip() for line in exported.text.splitlines() if not line.startswith("#")]
    assert lines[:7] == ["kinematics:", "shoulder:", "x: 0.0", "y: 0.0", "z: 0.1273", "roll: 0.0", "pitch: 0.0"]
    assert lines[lines.index("forearm:") + 1] == "x: -0.612"
    assert lines[lines.index("wrist_1:") + 1 : lines.index("wrist_1:") + 4] == ["x: -0.5723", "y: 0.0", "z: 0.163941"]
    assert lines[-1].startswith("hash: calib_")


def test_the_residual_of_the_kinematics_file_is_what_its_reader_finds():
    robot = softened(flawed(arm(), np.random.default_rng(5)))
    exported = ec.export_robot(robot, "ur-yaml")
    q = ec.random_poses(robot, 1500, 99)
    read = np.array([pose_of_ur(exported.text, pose) for pose in q])  # the tool is at wrist_3
    flange = np.linalg.inv(read[0])
    rigid = replace(at_its_base(robot), elastic={}, transmission={})
    position, rotation = ec.predict(rigid, q[:1])
    tool = flange @ np.block([[rotation[0], position[0][:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])
    assert_left(robot, exported, read @ tool, q, "ur_description")
    assert f"# Cannot hold: {exported.cannot_hold[0]}\n" in exported.text


def corrected(nominal: Robot, text: str, columns: tuple[str, ...]) -> Robot:
    """The nominal robot with some columns of the corrections, and the tool."""
    rows = list(nominal.rows)
    for line in table(text):
        place = next((k for k, row in enumerate(rows) if row.name == line["row"]), None)
        if place is None:
            continue
        geometry = dict(rows[place].geometry)
        for key in DH_KEYS:
            unit = "deg" if key in ("alpha", "beta", "theta") else "mm"
            delta = line.get(f"delta_{key} [{unit}]") if "deltas" in columns else None
            if rows[place].joint_element == f"{rows[place].name}.{key}":
                delta = rows[place].sign * line[f"offset [{unit}]"]
            geometry[key] = geometry.get(key, 0.0) + (
                np.deg2rad(delta or 0.0) if unit == "deg" else 1e-3 * (delta or 0.0)
            )
        rows[place] = replace(rows[place], geometry=geometry)
    return replace(nominal, rows=tuple(rows))


@pytest.mark.parametrize(
    ("reading", "columns"), [("geometry", ("deltas", "offset")), ("offsets and tool", ("offset",))]
)
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_corrections_added_to_the_nominal_robot_leave_what_is_stated(
    convention: str, reading: str, columns: tuple[str, ...]
):
    rng = np.random.default_rng(6)
    nominal = random_robot(rng, convention)
    robot = softened(flawed(nominal, rng))
    exported = ec.export_robot(robot, "corrections-csv", nominal=nominal)
    controller = at_its_base(corrected(nominal, exported.text, columns))
    q = ec.random_poses(robot, 3000, 99)
    for residual in exported.residuals:
        if residual.reading == reading and not residual.refitted:
            real = ec.predict(at_its_base(robot), q, load=residual.load)[0]
            left = np.linalg.norm(real - ec.predict(controller, q)[0], axis=1)
            assert residual.position.mean() == pytest.approx(left.mean(), rel=0.1)
    if reading == "geometry":
        bare = replace(at_its_base(robot), elastic={}, transmission={})
        np.testing.assert_allclose(ec.predict(controller, q)[0], ec.predict(bare, q)[0], rtol=0, atol=1e-9)


def test_corrections_state_stiffness_and_frames():
    nominal = arm()
    robot = replace(
        softened(flawed(nominal, np.random.default_rng(7))), tool=random_robot(np.random.default_rng(1), "urdf").tool
    )
    exported = ec.export_robot(robot, "corrections-csv", nominal=nominal)
    lines = {line["row"]: line for line in table(exported.text)}
    assert lines["1"]["stiffness"] == pytest.approx(1.0 / 3e-6)
    assert (lines["2"]["law"], lines["2"]["transition_torque"]) == ("hinge", 20.0)
    assert lines["2"]["stiffness_high"] == pytest.approx(1e6)
    assert lines["4"]["coefficients"] == "2e-06 -1e-12"
    assert lines["4"]["stiffness"] is None
    assert lines["tool"]["x [mm]"] == pytest.approx(1e3 * robot.tool.xyz[0])
    assert "base" not in lines
    with_all = [r for r in exported.residuals if r.reading == "geometry and compliance" and not r.refitted]
    # joint maps alone are missing, with and without the payload
    assert all(1e-6 < r.position.mean() < 5e-4 for r in with_all)
    assert [r.load for r in with_all] == [None, "heavy"]


def test_an_elastic_link_has_a_line_of_its_own():
    nominal = arm()
    robot = replace(nominal, elastic={"2.alpha": softened(nominal).elastic["1.theta"]})
    lines = {line["row"]: line for line in table(ec.export_robot(robot, "corrections-csv", nominal=nominal).text)}
    assert lines["2.alpha"]["stiffness"] == pytest.approx(1.0 / 3e-6)


@pytest.mark.parametrize("to", ["dh-csv", "mdh-csv", "ur-yaml"])
def test_coupled_joints_have_no_place_in_tables(to: str):
    robot = replace(arm(), coupling=tuple(tuple(float(i == j) for j in range(6)) for i in range(6)))
    with pytest.raises(InputError, match=f"--to {to}: the joints of arm are coupled"):
        ec.export_robot(robot, to)


def test_the_kinematics_file_is_for_six_turning_joints():
    with pytest.raises(InputError, match="expected six revolute joints, found 5"):
        ec.export_robot(replace(arm(), rows=arm().rows[:5]), "ur-yaml")


def test_a_format_that_does_not_exist_is_told_with_those_that_do():
    with pytest.raises(InputError, match="no format 'ufrd'; did you mean 'urdf'"):
        ec.export_robot(arm(), "ufrd")


@pytest.mark.parametrize("to", ["urdf", "dh-csv", "mdh-csv", "ur-yaml"])
def test_a_tool_that_is_not_known_is_said_to_be_none(to: str):
    assert "The tool is not known: its frame is written as the flange's." in ec.export_robot(arm(), to).notes
