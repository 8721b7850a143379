"""Steps, hinges and cubics on the command line: options, messages, result.json, and what is printed."""

from __future__ import annotations

import json
import shutil
from typing import Any

import numpy as np
import pytest

import elastocal as ec
from support.calibrations import measured
from support.files import Desk, desk
from support.robots import arm
from support.transitions import actual_arm
from test_cli_golden import GOLDEN
from test_cli_result import CONTRACT, departures

__all__ = ["desk"]


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    """A desk with an arm that has a step and a hinge."""
    desk = Desk(tmp_path_factory.mktemp("laws"))
    data = measured(actual_arm(arm(), {"2": "step", "3": "hinge"}), 50, 0, noise=2e-5)
    ec.save_robot(arm(), desk.folder / "robot.toml")
    ec.save_measurements(data, arm(), desk.folder / "fit.csv")
    return desk


def result_of(desk: Desk, options: str) -> dict[str, Any]:
    return json.loads(desk.done(f"calibrate robot.toml fit.csv {options} --json"))


METHODS = {
    "exact": ("", "exact", True),
    "asked for": ("--transition exact", "exact", True),
    "genetic": ("--transition ga --population 6 --generations 3", "ga", False),
    "given": ("--transition 222,80.5", "given", False),
}


@pytest.mark.parametrize("case", METHODS)
def test_the_result_object_says_how_transition_torques_were_found(shared: Desk, case: str):
    options, method, proven = METHODS[case]
    result = result_of(shared, f"--elastic 2:step,3:hinge,5 {options}")
    contract = {**CONTRACT, "residuals": {}}
    assert list(departures(result, contract)) == []
    search = result["search"]
    assert (search["method"], search["proven"]) == (method, proven)
    assert search["fits"] >= 1
    assert len(search["best_fitness"]) == (3 if method == "ga" else 0)
    assert search["seconds"] >= 0.0
    assert result["settings"]["elastic"] == {"2": "step", "3": "hinge", "5": "linear"}


@pytest.mark.parametrize("case", METHODS)
def test_the_result_object_says_what_the_data_know_of_a_transition(shared: Desk, case: str):
    options, method, _ = METHODS[case]
    elements = {e["element"]: e for e in result_of(shared, f"--elastic 2:step,3:hinge,5 {options}")["elastic"]}
    assert [e["law"] for e in elements.values()] == ["step", "hinge", "linear"]
    for name in ("2.theta", "3.theta"):
        found = elements[name]
        low, high = found["transition_gap"]
        assert low < found["transition_torque"] <= high
        assert sum(found["loads"].values()) == 50
        assert (found["transition_std"] is None) == (method == "given")
        assert len(found["coefficients"]) == len(found["std"]) == 2
    assert not {"transition_gap", "transition_std", "loads"} & set(elements["5.theta"])
    if method == "given":
        assert [elements[name]["transition_torque"] for name in ("2.theta", "3.theta")] == [222.0, 80.5]


def test_settings_say_what_was_asked_for(shared: Desk):
    def settings(options: str) -> tuple[object, bool]:
        found = result_of(shared, f"--elastic 2:step {options}")["settings"]
        return found["transition"], found["non_negative"]

    assert settings("") == ("exact", False)
    assert settings("--transition 222 --non-negative") == ([222.0], True)
    asked = {"method": "ga", "population": 4, "generations": 2}
    assert settings("--transition ga --population 4 --generations 2") == (asked, False)


def test_without_a_transition_to_find_there_is_no_search(shared: Desk):
    assert result_of(shared, "--elastic 2:cubic,3")["search"] is None
    assert result_of(shared, "")["search"] is None


def test_the_calibrated_robot_predicts_on_as_its_result_says(desk: Desk, shared: Desk):
    for name in ("robot.toml", "fit.csv"):
        shutil.copy(shared.folder / name, desk.folder)
    result = json.loads(desk.done("calibrate robot.toml fit.csv --elastic 2:step,3:hinge,5:cubic -o out --json"))
    robot = ec.load_robot(desk.folder / "out" / "robot.toml")
    for element in result["elastic"]:
        found = robot.elastic[element["element"]]
        assert (found.law, list(found.coefficients)) == (element["law"], element["coefficients"])
        assert found.transition_torque == element["transition_torque"]
    again = json.loads(desk.done("validate out/robot.toml fit.csv --json"))["residuals"]["held_out"]
    assert again == pytest.approx(result["residuals"]["calibrated"], rel=1e-6)


def test_the_same_seed_gives_the_same_genetic_search(shared: Desk):
    command = "--elastic 2:step,3:hinge --transition ga --population 5 --generations 2 --seed {}"
    searches = [result_of(shared, command.format(seed))["search"]["best_fitness"] for seed in (1, 1, 2)]
    assert searches[0] == searches[1] != searches[2]


def test_non_negative_keeps_compliances_at_zero_or_above(desk: Desk):
    actual = actual_arm(arm(), {"2": "step"})
    ec.save_robot(arm(), desk.folder / "robot.toml")
    for seed in range(6):
        ec.save_measurements(measured(actual, 40, seed, noise=2e-4), arm(), desk.folder / "fit.csv")
        free = result_of(desk, "--elastic 2,3,4,5,6")
        bounded = result_of(desk, "--elastic 2,3,4,5,6 --non-negative")
        lowest = [min(e["coefficients"][0] for e in found["elastic"]) for found in (free, bounded)]
        if lowest[0] < 0.0:
            assert lowest[1] == 0.0
            assert any("held at zero" in warning for warning in bounded["warnings"])
            return
    raise AssertionError("no seed gave a negative compliance")


REFUSED = {
    "--elastic 2:step --population 10": "--population and --generations go with --transition ga",
    "--elastic 2:step --generations 10 --transition exact": "--population and --generations go with --transition ga",
    "--elastic 2:step --population 10 --transition 222": "--population and --generations go with --transition ga",
    "--elastic 2:step --transition exactly": "--transition exactly: expected exact, ga, or torques in N m with commas",
    "--elastic 2:step --transition 222,": "--transition 222,: expected exact, ga, or torques in N m with commas",
    "--elastic 2:step --transition 222;80": "--transition 222;80: expected exact, ga, or torques in N m with commas",
    "--elastic 2:step,3:hinge --transition 222": (
        "transition: expected one torque for each element with a transition (2.theta, 3.theta), found 1"
    ),
    "--elastic 2:step,3 --transition 222,80": (
        "transition: expected one torque for each element with a transition (2.theta), found 2"
    ),
    "--elastic 2,3:cubic --transition 222": (
        "transition: expected one torque for each element with a transition (none: ask for a step or hinge law, "
        "as --elastic 2:step), found 1"
    ),
    "--elastic 2:step --transition 0": "transition: expected a positive torque, found 0",
    "--elastic 2:step --transition=-222": "transition: expected a positive torque, found -222",
    "--elastic 2:step --transition nan": "transition: expected a positive torque, found nan",
    "--elastic 2:step --transition inf": "transition: expected a positive torque, found inf",
    "--elastic 2:stepp": "element 2: no law 'stepp'; did you mean 'step'? (valid: linear, step, hinge, cubic)",
    "--elastic 2:step,2:hinge": "--elastic 2:step,2:hinge: element '2' is named twice",
    "--elastic 2:step --fix 2.theta.c_low": (
        "2.theta: identify both coefficients of its law, or fix both (--fix '2.theta.*')"
    ),
    "--elastic 2:step --fix 2.theta.c": "--fix no parameter matches '2.theta.c'; did you mean ",
}


@pytest.mark.parametrize("options", REFUSED)
def test_requests_for_laws_that_make_no_sense_are_told_and_nothing_is_written(shared: Desk, options: str):
    (told,) = shared.refused(f"calibrate robot.toml fit.csv {options} -o out")
    assert told.startswith(REFUSED[options])


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        ("--transition ga --population 1", 'Invalid value "1" for --population. Must be >= 2.'),
        ("--transition ga --generations 0", 'Invalid value "0" for --generations. Must be >= 1.'),
        ("--transition ga --population ten", 'Invalid value for --population: unable to convert "ten" into int.'),
        ("--no-non-negative", "Unknown option: --no-non-negative."),
    ],
)
def test_sizes_that_make_no_sense_are_told(shared: Desk, options: str, fault: str):
    told = " ".join(
        line.strip("│ ") for line in shared.refused(f"calibrate robot.toml fit.csv --elastic 2:step {options}")
    )
    assert fault in told


def test_the_help_of_calibrate_names_the_laws_and_methods(desk: Desk):
    told = " ".join(line.strip("│ ") for line in desk.done("calibrate --help").splitlines())
    for word in ("step", "hinge", "cubic", "genetic algorithm", "222,80", "--non-negative", "--population"):
        assert word in told


def test_the_measurements_that_are_printed_are_of_two_steps():
    """What the golden file should be read beside."""
    actual = actual_arm(arm(), {"2": "step", "3": "step"}, 3)
    data = ec.load_measurements([GOLDEN / "step.csv"], ec.load_robot(GOLDEN / "robot.toml"))
    position, _ = ec.predict(actual, data.q)
    assert np.sqrt(((data.position - position) ** 2).sum(axis=1).mean()) < 5e-5
