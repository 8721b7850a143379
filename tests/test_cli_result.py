"""The contract of `calibrate --json` and of the folder that `-o DIR` makes."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastocal as ec
from support.files import Desk, contents, desk, save_simulated

__all__ = ["desk"]

COMMAND = "calibrate robot.toml fit.csv --held-out held_out.csv --elastic 2,3 -o result --json"

STATISTICS = {"n": int, "mean": float, "max": float, "rms": float, "std": float}

CONTRACT = {
    "format": str,
    "robot": str,
    "status": str,
    "verdict": str,
    "parameters": [{"name": str, "unit": str, "nominal": float, "identified": float, "std": float, "verdict": str}],
    "elastic": [
        {
            "element": str,
            "law": str,
            "transition_torque": float,
            "coefficients": [float],
            "std": [float],
            "verdict": str,
        }
    ],
    "residuals": dict.fromkeys(("nominal", "calibrated", "held_out_nominal", "held_out"), STATISTICS),
    "observability": {
        "rank": int,
        "parameters": int,
        "condition": float,
        **dict.fromkeys(("O1", "O2", "O3", "O4", "O5"), float),
    },
    "outliers": [Any],
    "warnings": [str],
    "iterations": int,
    "seconds": float,
    "settings": dict,
    "data_sha256": [str],
    "version": str,
}
"""Keys and types of result.json; more keys may be there."""

MAYBE_NULL = ("nominal", "std", "transition_torque")


def departures(found: Any, contract: Any, place: str = "result") -> Iterator[str]:
    """Where a value departs from a contract."""
    nullable = place.rpartition(".")[2].partition("[")[0] in MAYBE_NULL
    kinds = {dict: dict, list: list}.get(type(contract), contract)
    if contract is Any or (found is None and nullable):
        return
    if not isinstance(found, (int, float) if kinds is float else kinds) or isinstance(found, bool):
        yield f"{place} is {found!r}"
    elif isinstance(contract, dict):
        yield from (f"{place}.{key} is missing" for key in contract if key not in found)
        for key in contract.keys() & found.keys():
            yield from departures(found[key], contract[key], f"{place}.{key}")
    elif isinstance(contract, list):
        for i, item in enumerate(found):
            yield from departures(item, contract[0], f"{place}[{i}]")


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> tuple[Desk, dict[str, Any]]:
    """A desk where an arm has been calibrated, and the result object as printed."""
    desk = Desk(tmp_path_factory.mktemp("calibrated"))
    save_simulated(desk.folder, fit=40, held_out=25)
    return desk, json.loads(desk.done(COMMAND))


def test_the_result_object_has_the_keys_and_types_of_the_contract(calibrated: tuple[Desk, dict[str, Any]]):
    _, result = calibrated
    assert list(departures(result, CONTRACT)) == []
    assert result["format"] == "elastocal-result/1"
    assert result["status"] in ("converged", "not_converged", "not_identifiable")


def test_result_json_is_what_is_printed(calibrated: tuple[Desk, dict[str, Any]]):
    desk, result = calibrated
    assert json.loads((desk.folder / "result" / "result.json").read_text()) == result


def test_verdicts_of_parameters_are_of_the_vocabulary_and_go_with_their_numbers(
    calibrated: tuple[Desk, dict[str, Any]],
):
    _, result = calibrated
    verdicts = {parameter["verdict"] for parameter in result["parameters"]}
    assert verdicts <= {"identified", "insignificant", "dependent", "unobservable", "fixed"}
    assert {"identified", "dependent", "unobservable"} <= verdicts
    for parameter in result["parameters"]:
        told = parameter["verdict"] in ("identified", "insignificant")
        assert (parameter["std"] is not None) == told
        if not told and parameter["nominal"] is not None:
            assert parameter["identified"] == parameter["nominal"]


def test_the_nominal_value_is_null_for_frames_without_a_first_guess_only(calibrated: tuple[Desk, dict[str, Any]]):
    _, result = calibrated
    null = [parameter["name"] for parameter in result["parameters"] if parameter["nominal"] is None]
    keys = ("tx", "ty", "tz", "rx", "ry", "rz")
    assert null == [f"{frame}.{key}" for frame in ("base", "tool") for key in keys]


def test_numbers_are_in_si_units(calibrated: tuple[Desk, dict[str, Any]]):
    _, result = calibrated
    found = {parameter["name"]: parameter for parameter in result["parameters"]}
    assert (found["3.a"]["unit"], found["3.a"]["nominal"]) == ("m", 0.6)
    assert (found["2.alpha"]["unit"], found["2.alpha"]["nominal"]) == ("rad", -math.pi / 2)
    assert {found[name]["unit"] for name in ("2.theta.c", "3.theta.c")} == {"rad/(N·m)"}
    assert abs(found["3.a"]["identified"] - 0.6) < 0.01
    assert 1e-7 < found["3.theta.c"]["identified"] < 1e-5
    assert 1e-6 < result["residuals"]["held_out"]["mean"] < 1e-4 < result["residuals"]["held_out_nominal"]["mean"] < 0.1


def test_elastic_elements_say_what_their_parameters_say(calibrated: tuple[Desk, dict[str, Any]]):
    _, result = calibrated
    found = {parameter["name"]: parameter for parameter in result["parameters"]}
    assert [(e["element"], e["law"], e["transition_torque"]) for e in result["elastic"]] == [
        ("2.theta", "linear", None),
        ("3.theta", "linear", None),
    ]
    for element in result["elastic"]:
        parameter = found[f"{element['element']}.c"]
        assert element["coefficients"] == [parameter["identified"]]
        assert element["std"] == [parameter["std"]]
        assert element["verdict"] == parameter["verdict"]


def test_hashes_and_settings_say_what_was_fitted(calibrated: tuple[Desk, dict[str, Any]]):
    desk, result = calibrated
    files = [(desk.folder / name).read_bytes() for name in ("fit.csv", "held_out.csv")]
    assert result["data_sha256"] == [hashlib.sha256(content).hexdigest() for content in files]
    assert result["settings"]["elastic"] == {"2": "linear", "3": "linear"}
    assert result["settings"]["seed"] == 0


def test_residuals_csv_has_one_row_for_each_measurement(calibrated: tuple[Desk, dict[str, Any]]):
    desk, result = calibrated
    with (desk.folder / "result" / "residuals.csv").open() as file:
        rows = list(csv.DictReader(file))
    places = [(row["file"], int(row["row"]), row["set"]) for row in rows]
    assert places == [("fit.csv", i, "fitted") for i in range(1, 41)] + [
        ("held_out.csv", i, "held_out") for i in range(1, 26)
    ]
    for name, column, chosen in (
        ("nominal", "nominal_error [mm]", "fitted"),
        ("calibrated", "calibrated_error [mm]", "fitted"),
        ("held_out_nominal", "nominal_error [mm]", "held_out"),
        ("held_out", "calibrated_error [mm]", "held_out"),
    ):
        errors = np.array([float(row[column]) for row in rows if row["set"] == chosen]) / 1e3
        assert np.sqrt((errors**2).mean()) == pytest.approx(result["residuals"][name]["rms"], rel=1e-6)
    first = rows[0]
    assert np.linalg.norm([float(first[f"calibrated_d{axis} [mm]"]) for axis in "xyz"]) == pytest.approx(
        float(first["calibrated_error [mm]"]), abs=1e-8
    )


def test_the_identified_robot_loads_again_with_its_frames_known(calibrated: tuple[Desk, dict[str, Any]]):
    desk, result = calibrated
    robot = ec.load_robot(desk.folder / "result" / "robot.toml")
    assert robot.base.known
    assert robot.tool.known
    for element in result["elastic"]:
        assert list(robot.elastic[element["element"]].coefficients) == element["coefficients"]


def test_validate_reproduces_the_held_out_statistics(calibrated: tuple[Desk, dict[str, Any]]):
    desk, result = calibrated
    again = json.loads(desk.done("validate result/robot.toml held_out.csv --json"))
    assert again["residuals"]["held_out"] == pytest.approx(result["residuals"]["held_out"], rel=1e-9)
    assert again["fitted_frames"] == []


def test_results_in_the_same_folder_are_overwritten_and_inputs_are_not(desk: Desk):
    save_simulated(desk.folder)
    before = contents(desk.folder)
    desk.done("calibrate robot.toml fit.csv -o result")
    first = (desk.folder / "result" / "result.json").read_bytes()
    (desk.folder / "result" / "notes.txt").write_text("mine")
    desk.done("calibrate robot.toml fit.csv --elastic 2 -o result")
    assert (desk.folder / "result" / "result.json").read_bytes() != first
    after = contents(desk.folder)
    assert set(after) - set(before) == {
        f"result/{name}" for name in ("robot.toml", "result.json", "residuals.csv", "report.html", "notes.txt")
    }
    assert {name: after[name] for name in before} == before


def test_a_result_is_no_place_for_a_calibration_that_starts_from_it(desk: Desk):
    save_simulated(desk.folder)
    desk.done("calibrate robot.toml fit.csv -o result")
    expected = "result/robot.toml is an input, which a result never overwrites: choose another place (-o)"
    assert desk.refused("calibrate result/robot.toml held_out.csv -o result") == [expected]
    desk.done("calibrate result/robot.toml held_out.csv -o again")


@pytest.mark.parametrize("call", [1, 2, 3, 4])
def test_should_one_result_not_be_written_none_is(desk: Desk, monkeypatch: pytest.MonkeyPatch, call: int):
    save_simulated(desk.folder)
    desk.done("calibrate robot.toml fit.csv -o result")
    replace, calls = Path.replace, []

    def failing(path: Path, target: Path) -> Path:
        calls.append(path)
        if len(calls) == call:
            raise OSError(28, "No space left on device")
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", failing)
    expected = "result: cannot be written to: no space left on device"
    assert desk.refused("calibrate robot.toml fit.csv --elastic 2,3 -o result") == [expected]


def test_json_has_standard_output_to_itself(desk: Desk):
    save_simulated(desk.folder)
    ran = desk.run("calibrate robot.toml fit.csv --json -o result")
    assert json.loads(ran.out)["status"] == "converged"
    assert ran.err == "result: robot.toml, result.json, residuals.csv, report.html\n"
    assert desk.run("calibrate robot.toml fit.csv --json").err == ""


def test_what_is_held_out_depends_on_the_seed_alone(desk: Desk):
    save_simulated(desk.folder)

    def held_out(seed: int) -> Any:
        return json.loads(desk.done(f"calibrate robot.toml fit.csv --holdout 0.3 --seed {seed} --json"))["residuals"]

    assert held_out(1) == held_out(1)
    assert held_out(1) != held_out(2)
    assert held_out(1)["held_out"]["n"] == 12


def test_a_calibration_without_held_out_rows_has_what_to_expect_instead(desk: Desk):
    save_simulated(desk.folder)
    result = json.loads(desk.done("calibrate robot.toml fit.csv --json"))
    assert set(result["residuals"]) == {"nominal", "calibrated", "cross_validated"}
