"""The command `simulate`: what it writes is what the other commands take, and what it refuses."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.robot import Compliance, Frame, Payload
from support.files import ROBOT, URDF, Desk, contents, desk, edited
from support.robots import arm

__all__ = ["desk"]

DRIVE = (3e11, 4e5, 2e5, 3e3)


def save_arm(desk: Desk, name: str = "robot.toml", **changes: object) -> None:
    ec.save_robot(replace(arm(), **changes), desk.folder / name)


def test_the_table_goes_to_standard_output_or_to_a_file(desk: Desk):
    desk.write(robot_toml=ROBOT)
    shown = desk.run("simulate robot.toml --poses 4")
    assert (shown.status, shown.err) == (0, "")
    assert shown.out.splitlines()[0] == "q1 [deg],q2 [deg],x [mm],y [mm],z [mm]"
    assert len(shown.out.splitlines()) == 5
    written = desk.run("simulate robot.toml --poses 4 -o sub/fit.csv")
    assert (written.status, written.out, written.err) == (0, "", "sub/fit.csv\n")
    assert (desk.folder / "sub" / "fit.csv").read_text() == shown.out
    assert "all rows" in desk.done("validate robot.toml sub/fit.csv")


def test_the_same_seed_gives_the_same_file(desk: Desk):
    desk.write(robot_toml=ROBOT)
    command = "simulate robot.toml --poses 9 --geometry-error 1mm,1mrad --noise 0.03mm --outliers 0.2 --seed"
    assert desk.done(f"{command} 1") == desk.done(f"{command} 1") != desk.done(f"{command} 2")


def test_a_drawn_robot_is_calibrated_and_its_file_tells_the_truth(desk: Desk):
    save_arm(desk)
    drawn = "--geometry-error 0.5mm,0.5mrad --write-actual actual.toml"
    desk.done(f"simulate robot.toml --poses 60 {drawn} --noise 0.03mm --floor 0.1m --state-sigma -o fit.csv")
    assert ec.load_measurements(desk.folder / "fit.csv", arm()).sigma == pytest.approx(np.full((60, 3), 3e-5))
    true = json.loads(desk.done("validate actual.toml fit.csv --json"))["residuals"]["held_out"]
    assert true["rms"] == pytest.approx(3e-5 * np.sqrt(3.0), rel=0.15)
    desk.done("simulate robot.toml --poses 100 --actual actual.toml --seed 1 -o held_out.csv")
    result = json.loads(desk.done("calibrate robot.toml fit.csv --held-out held_out.csv --json"))
    assert result["residuals"]["held_out"]["mean"] < 5e-5 < 0.1 * result["residuals"]["held_out_nominal"]["mean"]


def test_an_actual_robot_has_a_file_of_its_own(desk: Desk):
    save_arm(desk)
    soft = {"2.theta": Compliance("harmonic-drive", DRIVE)}
    save_arm(desk, "actual.toml", elastic=soft, tool=Frame((0.1, 0.0, 0.1)))
    desk.done("simulate robot.toml --poses 20 --actual actual.toml --kinds position,orientation -o fit.csv")
    assert ec.load_robot(desk.folder / "actual.toml").elastic == soft
    residual = json.loads(desk.done("validate actual.toml fit.csv --json"))["residuals"]["held_out"]
    assert residual["max"] < 1e-9 and residual["angle"]["max"] < 1e-9
    rigid = json.loads(desk.done("validate robot.toml fit.csv --json"))["residuals"]["held_out"]
    assert rigid["max"] > 1e-6


def test_payloads_targets_and_stations_are_named_in_the_table(desk: Desk):
    targets = {"a": Frame((0.1, 0.0, 0.0), known=True), "b": Frame((0.0, 0.1, 0.0), known=True)}
    save_arm(desk, targets=targets, loads={"heavy": Payload(20.0)}, stations={"north": Frame((1.0, 0.0, 0.0))})
    robot = ec.load_robot(desk.folder / "robot.toml")
    for options, expected in {
        "": {(None, "a", None): 4, (None, "b", None): 4},
        "--target b --load none,heavy": {(None, "b", None): 4, ("heavy", "b", None): 4},
        "--target b --target a --load heavy --station north": {("heavy", "a", "north"): 4, ("heavy", "b", "north"): 4},
    }.items():
        desk.done(f"simulate robot.toml --poses 8 {options} -o fit.csv")
        data = ec.load_measurements(desk.folder / "fit.csv", robot)
        assert {(c.load, c.target, c.station): len(c.rows) for c in data.combinations} == expected
        residual = json.loads(desk.done("validate robot.toml fit.csv --json"))["residuals"]["held_out"]
        assert residual["max"] < 1e-9


@pytest.mark.parametrize("noise", ["0.03mm", "30um", "0.03 mm", "3e-5", "0.003cm", "0.00003m", "0.03mm,0.03mm,3e-5"])
def test_units_may_be_any_and_none_is_si(desk: Desk, noise: str):
    desk.write(robot_toml=ROBOT)
    lines = desk.done(f"simulate robot.toml --poses 3 --noise '{noise}' --state-sigma").splitlines()
    assert [float(line.split(",")[-1]) for line in lines[1:]] == pytest.approx([0.03] * 3)


def test_one_sigma_stands_for_those_of_three_axes(desk: Desk):
    desk.write(robot_toml=ROBOT)
    last = desk.done("simulate robot.toml --poses 3 --noise 1mm,2mm,2mm --state-sigma").splitlines()[-1]
    assert float(last.split(",")[-1]) == pytest.approx(np.sqrt(3.0))


def test_where_the_target_may_be(desk: Desk):
    save_arm(desk, base=Frame((3.0, 0.0, 0.0), known=True))
    seen = "--floor -0.1m --box=2.5m,4,-1m,1000mm,-1,2m --range 2.8m,4m --cone 14deg"
    desk.done(f"simulate robot.toml --poses 50 {seen} -o fit.csv")
    position = ec.load_measurements(desk.folder / "fit.csv", arm()).position
    distance = np.linalg.norm(position, axis=1)
    assert position[:, 0].min() >= 2.5 and position[:, 2].min() > -0.1 and distance.min() >= 2.8
    assert 0.0 < np.abs(np.arctan2(position[:, 1], position[:, 0])).max() < 0.3


def test_a_urdf_is_simulated_too(desk: Desk):
    desk.write(robot_urdf=URDF)
    drawn = "--geometry-error 1mm,1mrad --write-actual actual.toml -o fit.csv"
    desk.done(f"simulate robot.urdf --tip l2 --poses 20 --kinds position,orientation {drawn}")
    residual = json.loads(desk.done("validate actual.toml fit.csv --json"))["residuals"]["held_out"]
    assert residual["max"] < 1e-9
    assert desk.done("simulate robot.urdf --tip l2 --actual actual.toml --poses 2").count("\n") == 3


LENGTHS = "(valid: m, mm, cm, um, µm, μm, in)"
ANGLES = "(valid: rad, deg, mrad, °)"

REFUSED = {
    "--noise 0.03inch": f"--noise 0.03inch: no length unit 'inch'; did you mean 'in'? {LENGTHS}",
    "--noise 0.03deg": f"--noise 0.03deg: no length unit 'deg' {LENGTHS}",
    "--noise-angle 1mm --kinds orientation": f"--noise-angle 1mm: no angle unit 'mm' {ANGLES}",
    "--noise mm": "--noise mm: expected a number and a unit of length (m, mm, cm, um, µm, μm, in; none: m), found 'mm'",
    "--noise 1e999mm": "--noise 1e999mm: expected a number and a unit of length",
    "--noise=-1mm": "--noise -1mm: expected 0 or a positive length, found -1mm",
    "--noise 0,03mm": "--noise 0,03mm: expected 3 numbers with commas between them (length, length, length), found 2",
    "--rounding 1um,1um": "--rounding 1um,1um: expected one number (length), found 2",
    "--geometry-error 1mm": "--geometry-error 1mm: expected 2 numbers with commas between them (length, angle), fo",
    "--geometry-error 1mrad,1mm": f"--geometry-error 1mrad,1mm: no length unit 'mrad' {LENGTHS}",
    "--box 0,1,0,1": "--box 0,1,0,1: expected 6 numbers with commas between them",
    "--box 0,1,0,1,1,0": "box: expected the lowest z and then the highest, found 1 m and 0 m",
    "--range 2m,1m": "range: expected the least distance and then the greatest, found 2 m and 1 m",
    "--cone 200deg": "cone: expected a half angle between 0 and 180 deg, found 200 deg",
    "--floor 9m": "found 0 of 5 poses: of ",
    "--kinds positions": "no kind 'positions'; did you mean 'position'? (valid: position, orientation, distance)",
    "--kinds orientaton --noise 1": "no kind 'orientaton'; did you mean 'orientation'?",
    "--kinds distance --noise 1,1,2": "noise: a distance has one standard deviation, found three",
    "--outliers 5": "outliers: expected a fraction of the rows, 0 to 1, found 5.0",
    "--outlier-size 1mm": "--outlier-size is of outliers, of which there are none: add --outliers 0.02",
    "--noise-angle 1mrad": "--noise-angle is of orientations, which are not measured",
    "--kinds orientation --rounding 1um": "--rounding is of positions and distances, which are not measured",
    "--load light": "robot.toml has no load 'light'",
    "--target nest": "robot.toml has no target 'nest' (valid: none)",
    "--station nort": "robot.toml has no station 'nort'; did you mean 'north'? (valid: north)",
    "--actual actual.toml": "actual.toml: no such file",
    "--actual robot.toml --geometry-error 1,1": "--geometry-error draws an actual robot: leave out --actual",
    "--actual other.toml": "other.toml: expected the joints of robot.toml, 2 (revolute, revolute), found 2 (rev",
    "--actual other.toml --load heavy": "other.toml: expected the joints of robot.toml",
    "-o robot.toml": "-o robot.toml: expected a CSV or Parquet file, as robot.csv, found .toml",
    "-o fit.toml": "-o fit.toml: expected a CSV or Parquet file, as fit.csv, found .toml",
    "-o gone.csv --write-actual robot.toml": "robot.toml is an input, which a result never overwrites",
    "--write-actual actual.csv": "--write-actual actual.csv: expected a robot file (.toml), found .csv",
    "--tip l2": "robot.toml: --tip is for a URDF",
}


@pytest.mark.parametrize("options", REFUSED)
def test_what_cannot_be_is_refused_and_nothing_is_written(desk: Desk, options: str):
    desk.write(robot_toml=ROBOT, other_toml=edited(ROBOT, ('a = 0.2\njoint = "revolute"', 'joint = "prismatic"')))
    before = contents(desk.folder)
    (fault,) = desk.refused(f"simulate robot.toml --poses 5 {options}")
    assert fault.startswith(REFUSED[options])
    assert contents(desk.folder) == before


@pytest.mark.parametrize("options", ["", "--poses 0", "--poses five", "--poses 5 --seed -1", "--poses 5 --nois 1mm"])
def test_usage_is_refused(desk: Desk, options: str):
    desk.write(robot_toml=ROBOT)
    assert desk.run(f"simulate robot.toml {options}").status == 2


def test_names_must_be_of_both_robots_and_all_faults_are_told(desk: Desk):
    desk.write(robot_toml=ROBOT, other_toml=edited(ROBOT, ("[load.heavy]", "[load.light]")))
    assert desk.refused("simulate robot.toml --actual other.toml --poses 5 --load heavy,light --station west") == [
        "robot.toml has no load 'light' (valid: heavy)",
        "robot.toml has no station 'west' (valid: north)",
        "other.toml has no load 'heavy' (valid: light)",
        "other.toml has no station 'west' (valid: north)",
    ]


@pytest.mark.parametrize(
    ("coefficients", "fault"),
    [
        ("[1e11, 4e5, 2e5]", "expected [a3, a1, k_sw, a_sw] of law 'harmonic-drive', found 3 numbers"),
        ("[1e11, 2e5, 4e5, 3e3]", "expected a1 above k_sw and 0, so that the drive is stiff, found 200000"),
        ("[1e11, 0.0, 0.0, 3e3]", "expected a1 above k_sw and 0, so that the drive is stiff, found 0"),
        ("[-1e11, 4e5, 2e5, 3e3]", "expected a3 of 0 or more, found -1e+11"),
        ("[1e11, 4e5, -2e5, 3e3]", "expected k_sw of 0 or more, found -200000"),
        ("[1e11, 4e5, 2e5, -3e3]", "expected a_sw of 0 or more, found -3000"),
    ],
)
def test_a_drive_that_no_load_settles_on_is_refused(desk: Desk, coefficients: str, fault: str):
    law = f'\n[elastic."elbow.theta"]\nlaw = "harmonic-drive"\ncoefficients = {coefficients}\n'
    desk.write(robot_toml=ROBOT + law)
    assert desk.refused("simulate robot.toml --poses 5") == [f'robot.toml: elastic."elbow.theta".coefficients: {fault}']


def test_poses_of_a_table_are_measured_with_the_names_that_they_bear(desk: Desk):
    named = {"targets": {"a": Frame((0.1, 0.0, 0.0)), "b": Frame((0.0, 0.1, 0.0))}, "loads": {"heavy": Payload(9.0)}}
    save_arm(desk, **named, elastic={"2.theta": Compliance("linear", (1e-5,))})
    desk.done("simulate robot.toml --poses 12 --target a,b --load none,heavy -o there.csv")
    desk.done("simulate robot.toml --at there.csv -o again.csv")
    robot = ec.load_robot(desk.folder / "robot.toml")
    there, again = (ec.load_measurements(desk.folder / name, robot) for name in ("there.csv", "again.csv"))
    np.testing.assert_allclose(again.position, there.position, atol=1e-12)
    assert (again.target.names, again.load.names) == (there.target.names, there.load.names)
    assert (again.target.codes == there.target.codes).all()
    assert (again.load.codes == there.load.codes).all()


def test_a_plan_is_measured_as_it_is(desk: Desk):
    save_arm(desk)
    desk.done("plan robot.toml --poses 12 --pool 200 -o plan.csv")
    desk.done("simulate robot.toml --at plan.csv --noise 0.03mm -o fit.csv")
    robot = ec.load_robot(desk.folder / "robot.toml")
    planned = ec.load_measurements(desk.folder / "plan.csv", robot, measured=False)
    measured = ec.load_measurements(desk.folder / "fit.csv", robot)
    np.testing.assert_allclose(measured.q, planned.q, atol=1e-12)
    unfilled = desk.refused("validate robot.toml plan.csv")
    assert "row 1" in unfilled[0]
    assert "found an empty cell" in unfilled[0]


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        ("", "expected --poses, how many poses are measured, or --at, a table of them; found neither"),
        (
            "--at there.csv --poses 3 --floor 0.1m --load heavy",
            "--at there.csv gives the poses, with their targets and payloads: leave out --load, --floor, --poses",
        ),
        ("--at missing.csv", "missing.csv: no such file (there: there.csv)"),
    ],
)
def test_poses_are_either_given_or_drawn(desk: Desk, options: str, fault: str):
    desk.write(robot_toml=ROBOT)
    desk.done("simulate robot.toml --poses 3 -o there.csv")
    assert desk.refused(f"simulate robot.toml {options} -o fit.csv") == [fault]


def test_poses_that_are_given_are_no_output(desk: Desk):
    desk.write(robot_toml=ROBOT)
    desk.done("simulate robot.toml --poses 3 -o there.csv")
    assert "is an input" in desk.refused("simulate robot.toml --at there.csv -o there.csv")[0]
