"""The command `validate`, of nominal and calibrated robots."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastocal as ec
from elastocal.robot import Frame, Robot
from support.files import Desk, contents, save_simulated
from support.robots import arm


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> tuple[Desk, Robot]:
    """A desk where an arm has been calibrated; the instrument was moved before moved.csv was measured."""
    desk = Desk(tmp_path_factory.mktemp("validated"))
    actual = save_simulated(desk.folder)
    desk.done("calibrate robot.toml fit.csv --elastic 2,3 -o result")
    moved = replace(actual, base=Frame((1.0, 2.0, 0.5), (0.1, 0.2, 0.3), known=True))
    data = ec.simulate(moved, ec.random_poses(moved, 30, 9), noise=1e-5, seed=9)
    ec.save_measurements(data, arm(), desk.folder / "moved.csv")
    return desk, actual


def validated(desk: Desk, arguments: str) -> dict[str, Any]:
    """What `validate --json` prints."""
    return json.loads(desk.done(f"validate {arguments} --json"))


def test_a_calibrated_robot_is_better_than_the_nominal_one(calibrated: tuple[Desk, Robot]):
    desk, _ = calibrated
    nominal = validated(desk, "robot.toml held_out.csv")
    found = validated(desk, "result/robot.toml held_out.csv")
    assert found["residuals"]["held_out"]["max"] < 0.1 * nominal["residuals"]["held_out"]["mean"]


def test_frames_that_the_robot_leaves_open_are_fitted_and_named(calibrated: tuple[Desk, Robot]):
    desk, _ = calibrated
    nominal = validated(desk, "robot.toml held_out.csv")
    assert {name.partition(".")[0] for name in nominal["fitted_frames"]} == {"base", "tool"}
    assert any("base, tool fitted to these data" in warning for warning in nominal["warnings"])
    assert validated(desk, "result/robot.toml held_out.csv")["warnings"] == []


def test_a_moved_instrument_is_fitted_anew_on_request(calibrated: tuple[Desk, Robot]):
    desk, _ = calibrated
    there = validated(desk, "result/robot.toml moved.csv")
    again = validated(desk, "result/robot.toml moved.csv --refit base")
    assert there["residuals"]["held_out"]["mean"] > 0.5
    assert again["residuals"]["held_out"]["mean"] < 1e-4
    assert {name.partition(".")[0] for name in again["fitted_frames"]} == {"base"}


def test_several_files_are_judged_together_and_each(calibrated: tuple[Desk, Robot]):
    desk, _ = calibrated
    found = validated(desk, "result/robot.toml fit.csv held_out.csv")
    assert found["residuals"]["held_out"]["n"] == 80
    assert {name: part["n"] for name, part in found["parts"].items()} == {"fit.csv": 40, "held_out.csv": 40}
    assert len(found["data_sha256"]) == 2


def test_the_residuals_of_every_row_are_written(calibrated: tuple[Desk, Robot]):
    desk, _ = calibrated
    found = validated(desk, "result/robot.toml fit.csv held_out.csv -o new/residuals.csv")
    with (desk.folder / "new" / "residuals.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["file"], row["row"]) for row in rows[38:42]] == [
        ("fit.csv", "39"),
        ("fit.csv", "40"),
        ("held_out.csv", "1"),
        ("held_out.csv", "2"),
    ]
    errors = [float(row["error [mm]"]) for row in rows]
    assert np.mean(errors) == pytest.approx(1e3 * found["residuals"]["held_out"]["mean"], rel=1e-6)
    fitted = ec.load_measurements(desk.folder / "fit.csv", arm())
    np.testing.assert_allclose([float(rows[0][f"q{i}"]) for i in range(1, 7)], fitted.q[0], atol=1e-9)


def test_a_file_of_residuals_may_be_written_again(calibrated: tuple[Desk, Robot], tmp_path: Path):
    desk, _ = calibrated
    for data in ("fit.csv", "held_out.csv"):
        desk.done(f"validate robot.toml {data} -o {tmp_path}/residuals.csv")
    assert list(contents(tmp_path)) == ["residuals.csv"]
    assert b"held_out.csv" in (tmp_path / "residuals.csv").read_bytes()


def test_orientations_have_statistics_of_their_own(calibrated: tuple[Desk, Robot]):
    desk, actual = calibrated
    data = ec.simulate(actual, ec.random_poses(actual, 30, 8), kinds=("position", "orientation"), noise_angle=1e-4)
    ec.save_measurements(data, arm(), desk.folder / "poses.csv")
    found = validated(desk, "robot.toml poses.csv -o poses-residuals.csv")["residuals"]["held_out"]
    assert set(found["angle"]) >= {"n", "mean", "max", "rms", "std"}
    assert 1e-5 < found["angle"]["mean"] < 0.1
    assert "angle [mrad]" in (desk.folder / "poses-residuals.csv").read_text().splitlines()[0]
    assert "angle [mrad]" in desk.done("validate robot.toml poses.csv")
