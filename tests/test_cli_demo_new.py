"""The commands `demo` and `new`: what they make is what the other commands take."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import elastocal as ec
from elastocal.cli.full_demo import contents as contents_of_the_full_demo
from support.files import URDF, Desk, contents, desk

__all__ = ["desk"]

RESULT = {"robot.toml", "result.json", "residuals.csv", "report.html"}


def test_the_demo_ends_well_and_its_files_can_be_used_again(desk: Desk):
    told = desk.done("demo -o shown --seed 3")
    assert set(contents(desk.folder / "shown")) == {"robot.toml", "fit.csv", "held_out.csv"} | {
        f"result/{name}" for name in RESULT
    }
    assert "elastocal calibrate shown/robot.toml shown/fit.csv" in told
    assert "The truth, since it is a simulation" in told
    found = json.loads(desk.done("validate shown/result/robot.toml shown/held_out.csv --json"))
    result = json.loads((desk.folder / "shown" / "result" / "result.json").read_text())
    assert found["residuals"]["held_out"] == pytest.approx(result["residuals"]["held_out"], rel=1e-9)
    assert result["residuals"]["held_out"]["mean"] < 0.2 * result["residuals"]["held_out_nominal"]["mean"]


def test_the_demo_may_be_repeated_and_finds_a_new_place_by_itself(desk: Desk):
    desk.done("demo --seed 1")
    first = contents(desk.folder)
    desk.done("demo --seed 1")
    assert {path.name for path in desk.folder.iterdir()} == {"elastocal-demo", "elastocal-demo-2"}
    desk.done("demo --seed 2 -o elastocal-demo")
    again = contents(desk.folder / "elastocal-demo")
    assert first["elastocal-demo/fit.csv"] == (desk.folder / "elastocal-demo-2" / "fit.csv").read_bytes()
    assert first["elastocal-demo/fit.csv"] != again["fit.csv"]


def test_the_demo_prints_one_result_object_if_asked_to(desk: Desk):
    ran = desk.run("demo --json")
    assert json.loads(ran.out)["status"] == "converged"
    assert "A simulated arm" in ran.err


def test_the_full_demo_goes_from_a_plan_to_corrected_targets(desk: Desk):
    """Errors of several millimetres fall below 0.05 mm, which the noise of the tracker hides."""
    told = desk.done("demo --full -o shown")
    steps = [line.split()[2] for line in told.splitlines() if line.startswith("$ elastocal")]
    expected = [
        "plan",
        "simulate",
        "simulate",
        "calibrate",
        "compensate",
        "simulate",
        "simulate",
        "validate",
        "validate",
    ]
    assert steps == expected
    assert float(told.partition("since it is a simulation: ")[2].split()[0]) < 0.05
    assert (desk.folder / "shown" / "result" / "report.html").is_file()
    found = json.loads(desk.done("validate shown/nominal.toml shown/after.csv --json"))["residuals"]["held_out"]
    before = json.loads(desk.done("validate shown/nominal.toml shown/before.csv --json"))["residuals"]["held_out"]
    assert before["mean"] > 1e-3
    assert found["mean"] < 0.07e-3
    assert max(len(line) for line in told.splitlines() if line.startswith(("$", "    --"))) <= 80


@pytest.mark.parametrize("as_json", ["", " --json"])
def test_the_full_demo_ends_where_a_step_is_refused(desk: Desk, as_json: str):
    """A folder stands where the plan is to be written."""
    (desk.folder / "shown" / "plan.csv").mkdir(parents=True)
    desk.write(**{"shown/robot_toml": contents_of_the_full_demo(0)["robot.toml"]})
    ran = desk.run(f"demo --full -o shown{as_json}")
    assert ran.status == 2
    assert "shown/plan.csv: expected a file to write, found a folder" in ran.err
    assert "the demo ends here: Which poses to measure" in ran.err
    assert "elastocal simulate" not in ran.out


def test_the_full_demo_prints_one_object_if_asked_to(desk: Desk):
    ran = desk.run("demo --full -o shown --json")
    found = json.loads(ran.out)
    assert (ran.status, found["format"]) == (0, "elastocal-demo/1")
    assert found["after"]["residuals"]["held_out"]["mean"] < 0.1 * found["before"]["residuals"]["held_out"]["mean"]
    assert found["calibrate"]["status"] == "converged"


def test_a_demo_that_was_changed_by_hand_is_not_overwritten(desk: Desk):
    desk.done("demo -o shown")
    robot = desk.folder / "shown" / "robot.toml"
    robot.write_text(robot.read_text().replace("a = 600.0", "a = 601.0"))
    faults = desk.refused("demo -o shown")
    assert faults[0] == "shown/robot.toml is there already, and not of a demo: choose another folder (-o)"


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
@pytest.mark.parametrize("joints", [1, 6, 7])
def test_a_new_robot_file_loads_and_its_table_fits(desk: Desk, convention: str, joints: int):
    told = desk.done(f"new cell --joints {joints} --convention {convention}")
    assert "elastocal calibrate cell/robot.toml cell/measurements.csv -o cell/result" in told
    robot = ec.load_robot(desk.folder / "cell" / "robot.toml")
    assert (robot.name, robot.convention, len(robot.joints)) == ("cell", convention, joints)
    table = desk.folder / "cell" / "measurements.csv"
    expected = "cell/measurements.csv: expected at least one row of measurements, found none"
    assert desk.refused("validate cell/robot.toml cell/measurements.csv") == [expected]
    table.write_text(table.read_text() + ",".join(["10"] * joints + ["1", "2", "3"]) + "\n")
    desk.done("validate cell/robot.toml cell/measurements.csv")


def test_orientation_columns_are_there_if_asked_for(desk: Desk):
    desk.done("new cell --orientation")
    header = (desk.folder / "cell" / "measurements.csv").read_text()
    assert header == "q1 [deg],q2 [deg],q3 [deg],q4 [deg],q5 [deg],q6 [deg],x [mm],y [mm],z [mm],qw,qx,qy,qz\n"


@pytest.mark.parametrize("slides", [False, True])
def test_a_new_robot_may_come_from_a_urdf(desk: Desk, slides: bool):
    desk.write(robot_urdf=URDF.replace('"continuous"', '"prismatic"') if slides else URDF)
    desk.done("new cell --urdf robot.urdf --tip l2")
    assert ec.load_robot(desk.folder / "cell" / "robot.toml") == ec.load_robot(desk.folder / "robot.urdf")
    header = (desk.folder / "cell" / "measurements.csv").read_text()
    assert header == f"q1 [deg],q2 [{'mm' if slides else 'deg'}],x [mm],y [mm],z [mm]\n"


@pytest.mark.parametrize("name", ['my "robot"', "back\\slash", "Größe № 1"])
def test_whatever_the_folder_is_called_the_robot_file_loads(tmp_path: Path, name: str):
    (tmp_path / name).mkdir()
    Desk(tmp_path / name).done("new .")
    assert ec.load_robot(tmp_path / name / "robot.toml").name == name


def test_new_does_not_overwrite_what_it_made(desk: Desk):
    desk.done("new cell")
    assert desk.refused("new cell --joints 7") == [
        f"cell/{name} is there already: choose another folder" for name in ("robot.toml", "measurements.csv")
    ]
