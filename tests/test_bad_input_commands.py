"""Options that make no sense: exit status 2, a sentence, nothing written."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from support.files import ROBOT, TABLE, Desk, desk, edited, save_simulated

__all__ = ["desk"]

USAGE = {
    "an unknown command": ("calibrat robot.toml fit.csv", 'Unknown command "calibrat". Did you mean "calibrate"?'),
    "an unknown option": (
        "calibrate robot.toml fit.csv --holdot 0.3",
        "Unknown option: --holdot. Did you mean --holdout?",
    ),
    "no robot": ("calibrate", 'Command "calibrate" parameter ROBOT requires an argument.'),
    "a fraction that is text": (
        "calibrate robot.toml fit.csv --holdout some",
        'Invalid value for --holdout: unable to convert "some" into float.',
    ),
    "a seed below zero": ("calibrate robot.toml fit.csv --seed -1", 'Invalid value "-1" for --seed. Must be >= 0.'),
    "a convention that is none": (
        "new cell --convention dh",
        'Invalid value "dh" for --convention. Choose from: "modified-dh", "standard-dh".',
    ),
}

REQUESTS = {
    "a fraction above one": (
        "calibrate robot.toml fit.csv --holdout 1.5 -o out",
        "holdout is 1.5: expected a fraction between 0 and 1, as 0.3",
    ),
    "a fraction of zero": (
        "calibrate robot.toml fit.csv --holdout 0 -o out",
        "holdout is 0: expected a fraction between 0 and 1, as 0.3",
    ),
    "held-out rows both given and asked for": (
        "calibrate robot.toml fit.csv --holdout 0.3 --held-out held_out.csv -o out",
        "held-out rows are given and asked for (held_out and holdout): give one of the two",
    ),
    "patterns to identify that match nothing": (
        "calibrate robot.toml fit.csv --identify 9.* -o out",
        "--identify no parameter matches '9.*' (valid: base.tx, base.ty, ",
    ),
    "patterns to fix that match nothing": (
        "calibrate robot.toml fit.csv --fix *.thea -o out",
        "--fix no parameter matches '*.thea'; did you mean ",
    ),
    "an element that is not there": (
        "calibrate robot.toml fit.csv --elastic 2,9 -o out",
        "no element '9' (valid: 1, 2, 3, 4, 5, 6, 1.a",
    ),
    "a law that does not exist": (
        "calibrate robot.toml fit.csv --elastic 2:linar -o out",
        "element 2: no law 'linar'; did you mean 'linear'? (valid: linear",
    ),
    "an element named twice": (
        "calibrate robot.toml fit.csv --elastic 2:linear,3,2 -o out",
        "--elastic 2:linear,3,2: element '2' is named twice",
    ),
    "no element": (
        "calibrate robot.toml fit.csv --elastic 2, -o out",
        "--elastic 2,: expected elements as in 2,3 or ",
    ),
    "a frame that is not there": (
        "validate robot.toml fit.csv --refit bse -o out.csv",
        "--refit: no frame 'bse'; did you mean 'base'? (valid: base, tool)",
    ),
}


@pytest.mark.parametrize("case", USAGE)
def test_wrong_usage_is_told_on_standard_error(desk: Desk, case: str):
    command, expected = USAGE[case]
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    told = " ".join(line.strip("│ ") for line in desk.refused(command))
    assert expected in told


@pytest.mark.parametrize("case", REQUESTS)
def test_requests_that_make_no_sense_are_told_and_nothing_is_written(desk: Desk, case: str):
    command, expected = REQUESTS[case]
    save_simulated(desk.folder, fit=10, held_out=5)
    (told,) = desk.refused(command)
    assert told.startswith(expected)


def test_all_patterns_that_match_nothing_are_told_at_once(desk: Desk):
    save_simulated(desk.folder, fit=10, held_out=5)
    assert len(desk.refused("calibrate robot.toml fit.csv --identify 9.* 2.gamma --fix 8.* -o out")) == 3


def test_an_element_named_in_two_ways_is_told(desk: Desk):
    save_simulated(desk.folder, fit=40, held_out=5)
    (told,) = desk.refused("calibrate robot.toml fit.csv --elastic 2,2.theta -o out")
    assert "2.theta" in told


@pytest.mark.parametrize("json", ["", " --json"])
@pytest.mark.parametrize(
    ("place", "fault"),
    [
        (".", "robot.toml is an input, which a result never overwrites: choose another place (-o)"),
        ("fit.csv", "fit.csv: expected a folder to write into, found a file"),
        ("fit.csv/out", "fit.csv: expected a folder to write into, found a file"),
        ("blocked", "blocked/result.json: expected a file to write, found a folder"),
        ("other", "other/robot.toml is not the result of a calibration: choose another folder (-o DIR)"),
        ("n" * 300, "n" * 300 + ": cannot be written to: file name too long"),
    ],
)
def test_a_place_that_results_cannot_go_to_is_told_before_the_work(desk: Desk, place: str, fault: str, json: str):
    (desk.folder / "blocked" / "result.json").mkdir(parents=True)
    (desk.folder / "other").mkdir()
    (desk.folder / "other" / "robot.toml").write_text(edited(ROBOT, ('"arm"', '"another arm"')))
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    assert desk.refused(f"calibrate robot.toml fit.csv -o {place}{json}") == [fault]


@pytest.mark.parametrize(
    ("place", "fault"),
    [
        (".", ".: expected a file to write, found a folder"),
        ("fit.csv/out.csv", "fit.csv: expected a folder to write into, found a file"),
        ("robot.toml", "robot.toml is an input, which a result never overwrites: choose another place (-o)"),
    ],
)
def test_a_place_that_residuals_cannot_go_to_is_told(desk: Desk, place: str, fault: str):
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    assert desk.refused(f"validate robot.toml fit.csv -o {place}") == [fault]


def test_a_folder_that_may_not_be_written_to_is_told(desk: Desk, monkeypatch: pytest.MonkeyPatch):
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    (desk.folder / "locked").mkdir()
    monkeypatch.setattr(
        "elastocal.io.files.os.access", lambda path, mode: not (mode & 2 and Path(path).name == "locked")
    )
    expected = "locked: cannot be written to: permission denied"
    assert desk.refused("calibrate robot.toml fit.csv -o locked") == [expected]


def test_a_file_that_may_not_be_read_is_told(desk: Desk, monkeypatch: pytest.MonkeyPatch):
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    monkeypatch.setattr("elastocal.io.files.os.access", lambda path, _: Path(path).name != "fit.csv")
    assert desk.refused("validate robot.toml fit.csv") == ["fit.csv: cannot be read: permission denied"]


@pytest.mark.parametrize(
    ("command", "fault"),
    [
        ("new cell --joints 0", "--joints 0: expected 1 to 30"),
        ("new cell --joints 31", "--joints 31: expected 1 to 30"),
        ("new cell --tip l2", "--tip goes with --urdf"),
        ("new cell --urdf robot.urdf", "robot.urdf: no such file"),
        ("new " + "n" * 300, "n" * 300 + "/robot.toml: file name too long"),
        ("new .", "robot.toml is there already: choose another folder"),
        ("demo -o .", "robot.toml is there already, and not of a demo: choose another folder (-o)"),
    ],
)
def test_new_and_demo_leave_what_is_there_alone(desk: Desk, command: str, fault: str):
    desk.write(robot_toml=ROBOT)
    assert desk.refused(command) == [fault]


@pytest.mark.parametrize("arguments", [["validate", "robot.toml", "fit.csv"], ["calibrate", "robot.toml", "--holdot"]])
def test_the_installed_command_exits_2_without_a_traceback(tmp_path: Path, arguments: list[str]):
    (tmp_path / "robot.toml").write_text(edited(ROBOT, ("alpha", "alfa")))
    (tmp_path / "fit.csv").write_text(TABLE)
    found = subprocess.run(
        [sys.executable, "-m", "elastocal", *arguments], cwd=tmp_path, capture_output=True, text=True
    )
    assert found.returncode == 2
    assert found.stdout == ""
    assert found.stderr
    assert "Traceback" not in found.stderr
