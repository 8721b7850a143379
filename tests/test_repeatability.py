"""Pose accuracy and repeatability after ISO 9283."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.measurements import Labels, Measurements
from elastocal.repeatability import repeatability
from support.files import Desk, desk
from support.robots import arm, placed

__all__ = ["desk"]


def repeated(poses: int, times: int) -> Measurements:
    """So many poses, each so many times, in no order."""
    q = np.repeat(np.random.default_rng(0).uniform(-1.0, 1.0, (poses, 6)), times, axis=0)
    return Measurements(q[np.random.default_rng(1).permutation(len(q))])


def test_one_pose_by_hand():
    errors = np.array([[3.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 3.0, 0.0]])
    found = repeatability(Measurements(np.zeros((3, 6))), errors)
    lengths = np.linalg.norm(errors - [1.0, 1.0, 0.0], axis=1)
    assert found.accuracy == pytest.approx((np.sqrt(2.0),) * 2)
    assert found.repeatability == pytest.approx((lengths.mean() + 3.0 * lengths.std(ddof=1),) * 2)
    assert (found.poses, found.repeats, found.judged) == (1, (3, 3), 1)


def test_an_offset_is_accuracy_and_no_repeatability():
    data, rng = repeated(10, 5), np.random.default_rng(2)
    errors = rng.standard_normal((50, 3))
    before, after = (repeatability(data, errors + offset) for offset in (0.0, [100.0, 0.0, 0.0]))
    assert after.repeatability == pytest.approx(before.repeatability, rel=1e-9)
    assert after.accuracy[0] == pytest.approx(100.0, abs=1.0)


def test_figures_scale_with_the_errors_and_do_not_depend_on_the_order():
    data, errors = repeated(8, 4), np.random.default_rng(2).standard_normal((32, 3))
    found, order = repeatability(data, errors), np.random.default_rng(3).permutation(32)
    larger = repeatability(data, 7.0 * errors)
    assert larger.accuracy == pytest.approx(tuple(7.0 * a for a in found.accuracy))
    assert larger.repeatability == pytest.approx(tuple(7.0 * r for r in found.repeatability))
    shuffled = repeatability(data.take(order), errors[order])
    assert shuffled.repeatability == pytest.approx(found.repeatability)
    assert shuffled.accuracy == pytest.approx(found.accuracy)


def test_normal_scatter_has_the_repeatability_that_theory_gives_it():
    data, errors = repeated(200, 30), np.random.default_rng(2).standard_normal((6000, 3))
    mean, deviation = np.sqrt(8.0 / np.pi), np.sqrt(3.0 - 8.0 / np.pi)  # of a length with three normal coordinates
    expected = (mean + 3.0 * deviation) * np.sqrt(29.0 / 30.0)  # about a barycentre of 30
    assert repeatability(data, errors).repeatability[0] == pytest.approx(expected, rel=0.02)


def test_poses_measured_once_and_twice():
    q = np.repeat(np.arange(3.0)[:, None] * np.ones(6), (1, 2, 3), axis=0)
    errors = np.random.default_rng(0).standard_normal((6, 3))
    found = repeatability(Measurements(q), errors)
    assert (found.poses, found.repeats, found.judged) == (2, (2, 3), 1)
    assert repeatability(Measurements(q[:3]), errors[:3]).repeatability is None
    assert repeatability(Measurements(q[:2]), errors[:2]) is None
    lost = np.where(np.arange(6)[:, None] < 3, errors, np.nan)
    assert repeatability(Measurements(q), lost).poses == 1


def test_another_target_or_payload_is_another_pose():
    data = replace(repeated(1, 4), target=Labels.of(["a", "b", "a", "b"]))
    errors = np.array([[0.0] * 3, [9.0] * 3, [0.0] * 3, [9.0] * 3])
    found = repeatability(data, errors)
    assert (found.poses, found.repeats) == (2, (2, 2))
    assert repeatability(replace(data, load=Labels.of(["x", None, "x", None])), errors).poses == 2
    assert repeatability(replace(data, load=Labels.of(["x", "y", None, None])), errors) is None


def test_validate_tells_it_where_there_are_repeats_only(desk: Desk):
    actual = placed(arm(), np.random.default_rng(0))
    q = ec.random_poses(actual, 10, 1)
    ec.save_robot(actual, desk.folder / "robot.toml")
    kinds = ("position", "orientation")
    for name, poses in (("once.csv", q), ("often.csv", np.repeat(q, 30, axis=0))):
        data = ec.simulate(actual, poses, kinds=kinds, noise=2e-5, noise_angle=1e-4)
        ec.save_measurements(data, actual, desk.folder / name)
    assert json.loads(desk.done("validate robot.toml once.csv --json"))["repeatability"] == {}
    assert "ISO 9283" not in desk.done("validate robot.toml once.csv")
    found = json.loads(desk.done("validate robot.toml often.csv --json"))["repeatability"]
    assert found["position"]["repeats"] == {"fewest": 30, "most": 30}
    assert found["position"]["RP"]["mean"] == pytest.approx(3.62 * 2e-5, rel=0.05)
    assert found["orientation"]["RP"]["mean"] == pytest.approx(3.62 * 1e-4, rel=0.05)
    assert found["position"]["AP"]["mean"] < 2e-5
    out = desk.done("validate robot.toml often.csv")
    assert "ISO 9283" in out
    assert max(map(len, out.splitlines())) <= 80
