"""Exit statuses, help, and what goes where."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import pytest

from elastocal.cli.main import COMMANDS
from support.files import Desk, desk, save_simulated

__all__ = ["desk"]


@pytest.mark.parametrize("command", COMMANDS)
def test_help_explains_each_command_with_an_example(desk: Desk, command: str):
    told = desk.done(f"{command} --help")
    assert f"Usage: elastocal {command}" in told
    assert re.search(rf"Example: .*elastocal {command} \S", " ".join(told.split()))


@pytest.mark.parametrize("arguments", ["", "--help"])
def test_without_a_command_all_are_listed(desk: Desk, arguments: str):
    told = desk.done(arguments)
    assert all(command in told for command in COMMANDS)


def test_the_version_is_that_of_the_package(desk: Desk):
    from importlib.metadata import version

    assert desk.done("--version").strip() == version("elastocal")


@pytest.mark.parametrize("option", ["", "--json", "-o result"])
def test_too_few_poses_are_a_failure_with_a_remedy(desk: Desk, option: str):
    save_simulated(desk.folder, fit=5, held_out=5)
    ran = desk.run(f"calibrate robot.toml fit.csv {option}")
    assert ran.status == 1
    told = " ".join(ran.out.split())
    assert "15 observed coordinates cannot determine 27 parameters: measure at least 4 more poses" in told


def test_a_failure_is_written_down_like_any_result(desk: Desk):
    save_simulated(desk.folder, fit=5, held_out=5)
    desk.done("calibrate robot.toml fit.csv -o result", status=1)
    result = json.loads((desk.folder / "result" / "result.json").read_text())
    assert result["status"] == "not_identifiable"
    assert result["verdict"].startswith("Not identifiable: ")
    assert any("cannot determine" in warning for warning in result["warnings"])


def test_a_single_row_is_a_failure_not_an_error(desk: Desk):
    save_simulated(desk.folder, fit=1, held_out=5)
    assert json.loads(desk.done("calibrate robot.toml fit.csv --json", status=1))["status"] == "not_identifiable"


def test_nothing_goes_to_standard_error_when_all_is_well(desk: Desk):
    save_simulated(desk.folder)
    for command in ("calibrate robot.toml fit.csv --holdout 0.3", "validate robot.toml fit.csv"):
        assert desk.run(command).err == ""


def test_only_the_parameters_that_match_are_identified(desk: Desk):
    save_simulated(desk.folder)
    command = "calibrate robot.toml fit.csv --identify *.theta 3.a --fix 4.* --json"
    parameters = json.loads(desk.done(command))["parameters"]
    told = {p["name"] for p in parameters if p["std"] is not None and not p["name"].startswith(("base", "tool"))}
    assert {"2.theta", "3.theta", "3.a"} <= told <= {"2.theta", "3.theta", "5.theta", "6.theta", "3.a"}
    assert {p["verdict"] for p in parameters if p["name"].startswith("4.")} == {"fixed"}


def test_a_reader_that_has_had_enough_is_no_failure(desk: Desk):
    save_simulated(desk.folder)
    arguments = [sys.executable, "-m", "elastocal", "calibrate", "robot.toml", "fit.csv"]
    running = subprocess.Popen(arguments, cwd=desk.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert running.stdout is not None
    running.stdout.close()
    assert running.stderr is not None
    assert running.stderr.read() == b""
    running.stderr.close()
    assert running.wait() == 0
