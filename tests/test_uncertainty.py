"""The uncertainty of predicted positions."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.identification import CalibrationResult
from elastocal.robot import Compliance, Frame, Robot
from elastocal.uncertainty import uncertainty_at
from support.calibrations import actual_in_gauge, gauge_of, measured
from support.files import Desk, desk, edited, save_simulated
from support.robots import arm, placed

__all__ = ["desk"]

LINEAR = {"2": "linear", "3": "linear"}


@pytest.fixture(scope="module")
def actual() -> Robot:
    """An arm with two soft joints that differs from the nominal one in what can be identified."""
    gauge = gauge_of(arm(), ("position",), LINEAR)
    robot = actual_in_gauge(arm(), gauge, np.random.default_rng(3))
    return replace(robot, elastic={"2.theta": Compliance("linear", (2e-6,)), "3.theta": Compliance("linear", (4e-6,))})


@pytest.fixture(scope="module")
def calibrated(actual: Robot) -> CalibrationResult:
    """Its calibration."""
    return ec.calibrate(arm(), measured(actual, 50, 1, noise=3e-5), elastic=LINEAR)


def test_the_position_is_what_predict_says(calibrated: CalibrationResult):
    q = ec.random_poses(arm(), 20, 7)
    found = ec.position_uncertainty(calibrated, q)
    np.testing.assert_allclose(found.position, ec.predict(calibrated.robot, q)[0], atol=1e-12)


def test_the_covariance_is_that_of_robots_displaced_by_chance(calibrated: CalibrationResult):
    q = ec.random_poses(arm(), 5, 7)
    found = ec.position_uncertainty(calibrated, q)
    rng = np.random.default_rng(0)
    draws = rng.multivariate_normal(np.zeros(len(calibrated.names)), calibrated.covariance, 800)
    moved = np.array(
        [
            ec.predict(calibrated.robot.displaced(dict(zip(calibrated.names, x, strict=True))), q)[0]
            for x in draws.tolist()
        ]
    )
    scatter = np.einsum("kni,knj->nij", moved - found.position, moved - found.position) / len(draws)
    scale = np.trace(found.covariance, axis1=1, axis2=2)[:, None, None]
    np.testing.assert_allclose(scatter / scale, found.covariance / scale, atol=0.08)


def test_calibrations_scatter_as_predicted(actual: Robot):
    q = ec.random_poses(arm(), 50, 7)
    truth = ec.predict(actual, q)[0]
    found, expected = [], []
    for seed in range(20):
        data = ec.simulate(actual, ec.random_poses(actual, 50, 1), noise=3e-5, seed=seed)
        result = ec.calibrate(arm(), data, elastic=LINEAR)
        found.append(((ec.predict(result.robot, q)[0] - truth) ** 2).sum(axis=1).mean())
        expected.append((ec.position_uncertainty(result, q).from_parameters ** 2).mean())
    assert np.sqrt(np.mean(found) / np.mean(expected)) == pytest.approx(1.0, abs=0.12)


def test_doubling_sigma_and_noise_doubles_the_standard_deviation(actual: Robot):
    q, poses, results = ec.random_poses(arm(), 10, 7), ec.random_poses(actual, 50, 1), []
    exact = ec.simulate(actual, poses).position
    noise = np.random.default_rng(0).standard_normal(exact.shape)
    for scale in (1e-6, 2e-6):
        data = replace(ec.simulate(actual, poses), position=exact + scale * noise, sigma=np.full(exact.shape, scale))
        results.append(ec.position_uncertainty(ec.calibrate(arm(), data, elastic=LINEAR), q))
    np.testing.assert_allclose(results[1].from_parameters, 2.0 * results[0].from_parameters, rtol=1e-3)
    np.testing.assert_allclose(results[1].total, np.hypot(results[1].from_parameters, results[1].from_model))


def test_the_model_error_is_what_the_residuals_leave(calibrated: CalibrationResult):
    found = ec.position_uncertainty(calibrated, ec.random_poses(arm(), 3, 7))
    assert found.from_model == pytest.approx(np.sqrt(3.0) * 3e-5, rel=0.15)


def test_where_the_instrument_stands_does_not_matter(actual: Robot, calibrated: CalibrationResult):
    moved = replace(actual, base=Frame((5.0, -1.0, 2.0), (0.7, -1.2, 2.0), known=True))
    result = ec.calibrate(arm(), measured(moved, 50, 1, noise=3e-5), elastic=LINEAR)
    q = ec.random_poses(arm(), 30, 7)
    ratio = [ec.position_uncertainty(r, q).from_parameters / r.model_sigma["position"] for r in (calibrated, result)]
    np.testing.assert_allclose(ratio[0], ratio[1], rtol=0.02)


def test_targets_and_loads_have_their_own(calibrated: CalibrationResult):
    robot = replace(placed(arm(), np.random.default_rng(0)), targets={"far": Frame((1.0, 0.0, 0.0), (0.0,) * 3, True)})
    known = replace(calibrated, robot=robot, names=("6.theta",), covariance=np.array([[1e-6]]))
    q = ec.random_poses(robot, 4, 1)
    at_tool = ec.position_uncertainty(known, q).from_parameters
    at_target = ec.position_uncertainty(known, q, target="far").from_parameters
    arms = [np.linalg.norm(ec.predict(robot, q, target=t)[0] - ec.predict(robot, q)[0], axis=1) for t in (None, "far")]
    assert (arms[0] == 0.0).all()
    assert not np.allclose(at_tool, at_target)


def test_measurements_without_anything_measured_have_uncertainty_and_no_ratio(calibrated: CalibrationResult):
    data = measured(calibrated.robot, 30, 4, noise=3e-5)
    assert uncertainty_at(calibrated, data).measured_ratio == pytest.approx(0.9, abs=0.25)
    assert uncertainty_at(calibrated, replace(data, position=None, distance=np.ones(30))).measured_ratio is None


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    """A desk where an arm has been calibrated."""
    desk = Desk(tmp_path_factory.mktemp("map"))
    save_simulated(desk.folder)
    desk.done("calibrate robot.toml fit.csv --elastic 2,3 -o result")
    return desk


def test_a_map_of_the_workspace(folder: Desk):
    found = json.loads(folder.done("validate result/robot.toml --uncertainty-map --poses 200 --json -o map/map.csv"))
    assert found["poses"] == 200
    with (folder.folder / "map" / "map.csv").open() as file:
        rows = list(csv.DictReader(file))
    total = np.array([float(row["std [mm]"]) for row in rows]) / 1e3
    assert np.median(total) == pytest.approx(found["std"]["total"]["median"], rel=1e-6)
    parts = [[float(row[f"std_{part} [mm]"]) for row in rows] for part in ("parameters", "model")]
    np.testing.assert_allclose(np.hypot(*parts), 1e3 * total, rtol=1e-6)
    q = np.array([[float(row[f"q{i}"]) for i in range(1, 7)] for row in rows])
    result = ec.load_result(folder.folder / "result")
    np.testing.assert_allclose(ec.position_uncertainty(result, q).total, total, rtol=1e-5)
    again = json.loads(folder.done("validate result/robot.toml --uncertainty-map --poses 200 --seed 1 --json"))
    assert again["std"] != found["std"]


def test_a_map_at_given_poses_needs_joint_positions_only(folder: Desk):
    lines = (folder.folder / "held_out.csv").read_text().splitlines()
    folder.write(q_csv="\n".join(",".join(line.split(",")[:6]) for line in lines) + "\n")
    poses = json.loads(folder.done("validate result/robot.toml q.csv --uncertainty-map --json"))
    whole = json.loads(folder.done("validate result/robot.toml held_out.csv --uncertainty-map --json"))
    assert poses["std"] == whole["std"]
    assert poses["measured_ratio"] is None
    assert 0.7 < whole["measured_ratio"] < 1.5
    assert "expected something measured" in folder.refused("validate result/robot.toml q.csv")[0]


def test_what_is_printed(folder: Desk):
    out = folder.done("validate result/robot.toml --uncertainty-map")
    for text in ("at 1000 poses", "from the parameters", "from the model's error", "together", "Largest at joint"):
        assert text in out
    assert max(map(len, out.splitlines())) <= 80


def test_a_robot_without_its_result_is_refused(folder: Desk):
    expected = ".: not the folder of a calibration (calibrate -o DIR): there is no result.json"
    assert folder.refused("validate robot.toml --uncertainty-map") == [expected]


def test_a_result_of_another_robot_is_refused(folder: Desk):
    text = (folder.folder / "result" / "robot.toml").read_text()
    other = folder.folder / "other"
    other.mkdir()
    (other / "result.json").write_bytes((folder.folder / "result" / "result.json").read_bytes())
    (other / "robot.toml").write_text(edited(text, ("a = 0.6", "a = 0.7")))
    assert "3.a is 0.7" in folder.refused("validate other/robot.toml --uncertainty-map")[0]
    (other / "robot.toml").write_text(edited(text, ('[elastic."3.theta"]', '[elastic."4.theta"]')))
    assert "arm has no parameter 3.theta.c" in folder.refused("validate other/robot.toml --uncertainty-map")[0]
    (other / "result.json").write_text('{"format": "elastocal-result/1"}')
    assert "covariance, parameters, model_sigma" in folder.refused("validate other/robot.toml --uncertainty-map")[0]
    (other / "result.json").write_text("{")
    assert "not valid JSON" in folder.refused("validate other/robot.toml --uncertainty-map")[0]


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        ("--uncertainty-map --target nest", "--target: "),
        ("--uncertainty-map --refit base", "--refit fits a frame"),
        ("held_out.csv --uncertainty-map --poses 5", "are of random poses"),
        ("held_out.csv --poses 5", "go with --uncertainty-map"),
    ],
)
def test_options_that_do_not_go_together(folder: Desk, arguments: str, fault: str):
    assert fault in folder.refused(f"validate result/robot.toml {arguments}")[0]
