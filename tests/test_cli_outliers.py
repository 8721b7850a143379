"""Outliers and faults at the command line: files and rows, remedies, exit statuses."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from support.files import Desk, desk
from support.outliers import NOISE, as_built, spoiled
from support.robots import arm

__all__ = ["desk"]


def save_spoiled(folder: Path) -> list[tuple[str, int]]:
    """Write robot.toml, mon.csv and tue.csv, some rows wrong; returns which."""
    actual = as_built(1)
    data, wrong = spoiled(ec.simulate(actual, ec.random_poses(actual, 70, 1), noise=NOISE), 1)
    ec.save_robot(arm(), folder / "robot.toml")
    ec.save_measurements(data.take(np.arange(40)), arm(), folder / "mon.csv")
    ec.save_measurements(data.take(np.arange(40, 70)), arm(), folder / "tue.csv")
    return [("mon.csv", row + 1) if row < 40 else ("tue.csv", row - 39) for row in wrong.tolist()]


COMMAND = "calibrate robot.toml mon.csv tue.csv --elastic 2,3"


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_outliers_are_listed_with_file_and_row(desk: Desk, loss: str):
    wrong = save_spoiled(desk.folder)
    result = json.loads(desk.done(f"{COMMAND} --loss {loss} -o result --json"))
    assert sorted((o["file"], o["row"]) for o in result["outliers"]) == wrong
    assert all(o["rejected"] and 4e-3 < o["residual"] < 0.06 and o["score"] > 10.0 for o in result["outliers"])
    assert result["settings"]["loss"] == loss
    assert result["residuals"]["calibrated"]["n"] == 70
    with (desk.folder / "result" / "residuals.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["file"], int(row["row"])) for row in rows if row["outlier"] == "true"] == wrong
    assert {row["set"] for row in rows} == {"fitted"}


def test_they_are_shown_with_what_became_of_them(desk: Desk):
    wrong = save_spoiled(desk.folder)
    told = desk.done(f"{COMMAND} --loss cauchy")
    section = told[told.index("\nOutliers\n") : told.index("Identified parameters")]
    for file, row in wrong:
        assert any(line.split()[:3] == [file, str(row), "position"] for line in section.splitlines())
    assert section.count("left out") == len(wrong)
    words = " ".join(told.split())
    assert f"{len(wrong)} outliers are left out of the fit: mon.csv rows" in words


def test_without_a_robust_loss_the_remedy_is_told(desk: Desk):
    save_spoiled(desk.folder)
    told = " ".join(desk.done(COMMAND).split())
    assert "too far from the fit of the others: mon.csv row" in told
    assert "repeat with --loss cauchy, which finds all outliers and leaves them out" in told


def test_without_outliers_nothing_is_said_of_them(desk: Desk):
    actual = as_built(2)
    ec.save_robot(arm(), desk.folder / "robot.toml")
    data = ec.simulate(actual, ec.random_poses(actual, 50, 2), noise=NOISE)
    ec.save_measurements(data, arm(), desk.folder / "fit.csv")
    command = "calibrate robot.toml fit.csv --elastic 2,3"
    assert json.loads(desk.done(f"{command} --json"))["outliers"] == []
    assert "utlier" not in desk.done(command)


def test_a_loss_that_does_not_exist_is_refused(desk: Desk):
    save_spoiled(desk.folder)
    ran = desk.run(f"{COMMAND} --loss tukey")
    assert ran.status == 2
    assert 'Choose from: "linear", "huber", "cauchy"' in " ".join(ran.err.split())


def test_a_fault_of_the_data_is_refused_and_nothing_is_written(desk: Desk):
    actual = as_built(3)
    data = ec.simulate(actual, ec.random_poses(actual, 50, 3), noise=NOISE)
    ec.save_robot(arm(), desk.folder / "robot.toml")
    ec.save_measurements(replace(data, position=data.position[:, [1, 0, 2]]), arm(), desk.folder / "fit.csv")
    (fault,) = desk.refused("calibrate robot.toml fit.csv -o result")
    assert fault.startswith("fit.csv: the points are mirrored (left-handed)")
    assert fault.endswith("swap two of the columns x, y, z, or change the sign of one")
