"""What changed between two calibrations: drift or noise."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.drift import LEVEL
from elastocal.identification import CalibrationResult
from elastocal.robot import Compliance, Frame, Robot
from support.calibrations import actual_in_gauge, gauge_of
from support.files import Desk, contents, edited, save_simulated
from support.robots import arm

LINEAR = {"2": "linear"}


@pytest.fixture(scope="module")
def actual() -> Robot:
    """An arm with a soft joint."""
    robot = actual_in_gauge(arm(), gauge_of(arm(), ("position",), LINEAR), np.random.default_rng(5))
    return replace(robot, elastic={"2.theta": Compliance("linear", (3e-6,))})


def calibrated(robot: Robot, seed: int, poses: int = 40, **options: object) -> CalibrationResult:
    data = ec.simulate(robot, ec.random_poses(robot, poses, seed), noise=2e-5, seed=seed)
    return ec.calibrate(arm(), data, **({"elastic": LINEAR} | options))


def test_a_calibration_does_not_differ_from_itself(actual: Robot):
    result = calibrated(actual, 1)
    found = ec.difference(result, result)
    assert (found.chi2, found.probability, found.drift) == (0.0, 1.0, False)
    assert {change.score for change in (*found.changes, *found.frames)} == {0.0}
    assert found.position == (0.0, 0.0)
    assert found.noise > 0.0
    assert found.warnings == ()


def test_noise_is_called_noise_and_comes_to_what_is_expected(actual: Robot):
    results = [calibrated(actual, seed) for seed in range(40)]
    found = [ec.difference(a, b, poses=50) for a, b in zip(results[::2], results[1::2], strict=True)]
    assert sum(d.drift for d in found) <= 1
    assert np.mean([d.chi2 / d.tested for d in found]) == pytest.approx(1.0, abs=0.2)
    ratio = np.sqrt(np.mean([d.position[0] ** 2 for d in found]) / np.mean([d.noise**2 for d in found]))
    assert ratio == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(("name", "change"), [("3.theta", 2e-4), ("4.d", 1e-4), ("2.theta.c", 4e-7)])
def test_drift_is_found_where_it_is(actual: Robot, name: str, change: float):
    found = ec.difference(calibrated(actual, 1), calibrated(actual.displaced({name: change}), 2))
    assert found.drift
    assert found.verdict.startswith("Drift")
    most = max(found.changes, key=lambda c: abs(c.score))
    assert most.name == name
    assert most.change == pytest.approx(change, abs=4.0 * most.std)
    assert f"{name} (+" in found.verdict


def test_at_the_flange_a_drift_is_as_large_as_it_is(actual: Robot):
    moved = actual.displaced({"3.theta": 5e-4})
    found = ec.difference(calibrated(actual, 1), calibrated(moved, 2))
    q = ec.random_poses(arm(), 1000, 0)
    none = Frame((0.0,) * 3, (0.0,) * 3, known=True)
    flange = [ec.predict(replace(robot, base=none, tool=none), q)[0] for robot in (actual, moved)]
    shift, turn = flange[1] - flange[0], flange[0] - flange[0].mean(axis=0)
    moves = [np.tile(axis, (1000, 1)) for axis in np.eye(3)] + [np.cross(axis, turn) for axis in np.eye(3)]
    moves = np.stack([move.ravel() for move in moves], axis=1)
    shift = shift.ravel() - moves @ np.linalg.lstsq(moves, shift.ravel())[0]
    true = np.sqrt((shift**2).sum() / 1000)
    assert found.position[0] == pytest.approx(true, rel=0.1)
    assert found.position[0] < found.position[1] < 3.0 * true


def test_a_moved_instrument_or_probe_is_no_drift(actual: Robot):
    moved = replace(
        actual,
        base=Frame((1.0, -2.0, 0.3), (3.1, 0.2, -3.0), known=True),
        tool=Frame((0.1, 0.05, 0.2), (0.0, 0.0, 0.0), known=True),
    )
    found = ec.difference(calibrated(actual, 1), calibrated(moved, 2))
    assert not found.drift
    assert {change.name.partition(".")[0] for change in found.frames} == {"base", "tool"}
    assert max(abs(change.score) for change in found.frames) > 100.0
    assert all(abs(change.change) <= np.pi for change in found.frames if change.unit == "rad")


def test_to_swap_the_two_changes_the_sign_only(actual: Robot):
    results = calibrated(actual, 1), calibrated(actual, 2)
    found, back = ec.difference(*results), ec.difference(*results[::-1])
    assert back.chi2 == pytest.approx(found.chi2, rel=1e-9)
    np.testing.assert_allclose([c.score for c in back.changes], [-c.score for c in found.changes])


def test_different_laws_are_refused(actual: Robot):
    with pytest.raises(ec.InputError, match=r"different laws of compliance \(2\.theta: linear; none\)"):
        ec.difference(calibrated(actual, 1), calibrated(actual, 2, elastic={}))


def test_different_robots_are_refused(actual: Robot):
    result = calibrated(actual, 1)
    other = replace(result, parameters=tuple(p for p in result.parameters if not p.name.startswith("6.")))
    with pytest.raises(ec.InputError, match=r"different robots: only one of them has the parameters 6\.a"):
        ec.difference(result, other)


def test_what_only_one_identified_is_told(actual: Robot):
    found = ec.difference(calibrated(actual, 1), calibrated(actual, 2, fix=["5.a"]))
    assert (found.only_before, found.only_after) == (("5.a",), ())
    assert any("did not identify the same" in warning for warning in found.warnings)


def test_different_nominal_robots_are_told(actual: Robot):
    data = ec.simulate(actual, ec.random_poses(actual, 40, 3), noise=2e-5, seed=3)
    other = ec.calibrate(arm().displaced({"1.d": 0.01}), data, elastic=LINEAR)
    found = ec.difference(calibrated(actual, 1), other)
    assert any("(1.d)" in warning for warning in found.warnings)


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    """A desk with calibrations of one arm, the third after a drift."""
    desk = Desk(tmp_path_factory.mktemp("diff"))
    robot = save_simulated(desk.folder)
    drifted = robot.displaced({"3.theta": 3e-4})
    data = ec.simulate(drifted, ec.random_poses(robot, 40, 9), noise=1e-5, seed=9)
    ec.save_measurements(data, arm(), desk.folder / "later.csv")
    for data_file, folder in (("fit", "first"), ("held_out", "second"), ("later", "third")):
        desk.done(f"calibrate robot.toml {data_file}.csv --elastic 2,3 -o {folder}")
    desk.done("calibrate robot.toml fit.csv -o rigid")
    return desk


def test_the_command_tells_noise_from_drift(folders: Desk):
    noise, drift = (json.loads(folders.done(f"diff first {other} --json")) for other in ("second", "third"))
    assert (noise["drift"], drift["drift"]) == (False, True)
    assert noise["probability"] > LEVEL > drift["probability"]
    most = max(drift["parameters"], key=lambda row: abs(row["score"]))
    assert most["name"] == "3.theta"
    assert most["after"] - most["before"] == pytest.approx(most["change"])
    assert drift["flange"]["rms"] > 5.0 * drift["flange"]["noise"]


def test_what_the_command_prints_fits_and_begins_with_what_changed_most(folders: Desk):
    out = folders.done("diff first third")
    assert max(map(len, out.splitlines())) <= 80
    assert next(line for line in out.splitlines() if ".theta" in line).split()[0] == "3.theta"
    assert "Drift: more changed than noise explains" in out
    assert "no drift of the robot" in " ".join(out.split())


def test_results_from_files_say_what_those_in_memory_say(folders: Desk):
    results = [ec.load_result(folders.folder / name) for name in ("first", "third")]
    found = ec.difference(*results)
    told = json.loads(folders.done("diff first third --json"))
    assert told["chi2"] == pytest.approx(found.chi2)


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        ("first nowhere", "nowhere: not the folder of a calibration (calibrate -o DIR): there is no result.json"),
        ("first robot.toml", "robot.toml: expected the folder of a calibration (calibrate -o DIR), found a file"),
        ("first rigid", "the calibrations have different laws of compliance (2.theta: linear, 3.theta: linear; none)"),
    ],
)
def test_what_cannot_be_compared_is_refused(folders: Desk, arguments: str, fault: str):
    assert folders.refused(f"diff {arguments}")[0].startswith(fault)


def test_a_damaged_folder_is_refused(folders: Desk):
    broken = folders.folder / "broken"
    broken.mkdir()
    for name, content in contents(folders.folder / "first").items():
        (broken / name).write_bytes(content)
    text = (broken / "robot.toml").read_text()
    (broken / "robot.toml").write_text(edited(text, ("b = 0.0\n", "b = 0.001\n")))
    expected = "broken/result.json does not belong to broken/robot.toml: "
    assert folders.refused("diff first broken")[0].startswith(expected)


def test_a_change_no_larger_than_the_models_error_may_be_that(actual: Robot):
    small, large = (
        ec.difference(calibrated(actual, 1), calibrated(actual.displaced({"3.theta": change}), 2))
        for change in (1e-4, 2e-3)
    )
    assert (small.drift, large.drift) == (True, True)
    assert any("measure the same ones" in warning for warning in small.warnings)
    assert large.warnings == ()
