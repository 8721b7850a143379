"""A real robot: UR10 and laser tracker, full poses, neither the tracker's place nor the tool known."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest

from elastocal.cli.main import main
from elastocal.identification import calibrate
from elastocal.io import load_measurements, load_robot, save_result
from elastocal.measurements import repeats, split
from elastocal.validation import validate
from support.data import UR10, needs_ur10

pytestmark = needs_ur10

ARGUMENTS = ["calibrate", str(UR10 / "robot.toml"), str(UR10 / "series_b.toml"), str(UR10 / "series_c.toml")]


def run(capsys, *options: str) -> dict:
    assert main([*ARGUMENTS, *options, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(("elastic", "bar"), [((), 0.475e-3), (("--elastic", "2,3,4,5"), 0.425e-3)])
def test_held_out_error_of_geometry_and_with_compliance(capsys, elastic, bar):
    began = time.perf_counter()
    result = run(capsys, "--holdout", "0.7", "--seed", "0", *elastic)
    assert time.perf_counter() - began < 2.0
    assert result["status"] == "converged"
    assert result["residuals"]["held_out_nominal"]["mean"] == pytest.approx(1.16e-3, abs=0.02e-3)
    assert result["residuals"]["held_out"]["mean"] <= bar
    assert result["residuals"]["held_out"]["n"] + result["residuals"]["calibrated"]["n"] == 4268


def test_compliances_of_joints_2_and_3_are_positive_and_near_1e_5(capsys):
    result = run(capsys, "--holdout", "0.7", "--seed", "0", "--elastic", "2,3")
    for element in result["elastic"]:
        assert element["verdict"] == "identified"
        assert 0.4e-5 < element["coefficients"][0] < 2e-5


def test_series_b_serves_series_c(tmp_path):
    """One series fitted, the other judged, with the frames of the first: one station, one mounting."""
    robot = load_robot(UR10 / "robot.toml")
    b, c = (load_measurements(UR10 / f"series_{name}.toml", robot) for name in "bc")
    result = calibrate(robot, b, held_out=c, elastic=dict.fromkeys("2345", "linear"))
    save_result(result, tmp_path)
    validation = validate(load_robot(tmp_path / "robot.toml"), c)
    assert validation.statistics.mean == pytest.approx(result.residuals["held_out"].mean, rel=1e-9)
    assert validation.statistics.mean < 0.6 * result.residuals["held_out_nominal"].mean
    assert validation.fitted_frames == ()
    assert validation.statistics.n == len(c) == 2773


def test_hold_outs_never_split_repeated_poses():
    robot = load_robot(UR10 / "robot.toml")
    data = load_measurements([UR10 / "series_b.toml", UR10 / "series_c.toml"], robot)
    fitted, held = split(data, 0.7, 0)
    pose = repeats(data)
    assert not set(pose[fitted]) & set(pose[held])
    assert len(held) == pytest.approx(0.7 * len(data), rel=0.01)
    sizes = np.bincount(pose[data.source.codes == 0])
    assert (sizes[pose[data.source.codes == 0]] > 1).sum() > 250


def test_weights_are_the_models_and_not_the_instruments():
    """Stated deviations of 0.01 mm explain next to nothing of what the model leaves."""
    robot = load_robot(UR10 / "robot.toml")
    data = load_measurements(UR10 / "series_b.toml", robot)
    sigma = calibrate(robot, data).model_sigma
    assert sigma["position"] > 10 * np.median(data.sigma)
    assert sigma["orientation"] > 5 * np.median(data.sigma_angle)
