"""Standard deviations and intervals by bootstrap."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.robot import Compliance, Robot
from support.calibrations import actual_in_gauge, gauge_of
from support.files import Desk, desk, save_simulated
from support.robots import arm
from support.transitions import SPRINGS

__all__ = ["desk"]

LINEAR = {"2": "linear"}


@pytest.fixture(scope="module")
def actual() -> Robot:
    """An arm with a soft joint."""
    robot = actual_in_gauge(arm(), gauge_of(arm(), ("position",), LINEAR), np.random.default_rng(5))
    return replace(robot, elastic={"2.theta": Compliance("linear", (3e-6,))})


def measured(actual: Robot, seed: int, poses: int = 30, **options: object) -> ec.Measurements:
    return ec.simulate(actual, ec.random_poses(actual, poses, seed), seed=seed, **({"noise": 2e-5} | options))


def deviations(result: ec.CalibrationResult) -> np.ndarray:
    return np.array([p.std for p in result.parameters if p.std is not None])


def test_on_average_it_agrees_with_the_linear_covariance(actual: Robot):
    ratios = []
    for seed in range(6):
        data = measured(actual, seed)
        linear, found = (ec.calibrate(arm(), data, elastic=LINEAR, bootstrap=n) for n in (0, 60))
        ratios.append(deviations(found) / deviations(linear))
    assert np.sqrt(np.mean(np.square(ratios))) == pytest.approx(1.0, abs=0.12)


def test_estimates_stay_and_the_result_says_how_many_fits_there_were(actual: Robot):
    data, calls = measured(actual, 1), []
    linear = ec.calibrate(arm(), data, elastic=LINEAR)
    found = ec.calibrate(
        arm(), data, elastic=LINEAR, bootstrap=20, on_sample=lambda done, total: calls.append((done, total))
    )
    assert [p.identified for p in found.parameters] == [p.identified for p in linear.parameters]
    assert found.residuals == linear.residuals
    assert calls == [(i + 1, 20) for i in range(20)]
    assert (found.bootstrap, linear.bootstrap) == ({"fits": 20, "failed": 0}, None)
    assert found.settings["bootstrap"] == 20
    assert any("bootstrap of 20 fits" in note for note in found.notes)
    for p in found.parameters:
        if p.interval is not None:
            assert p.interval[0] < p.interval[1]
            assert p.interval[1] - p.interval[0] == pytest.approx(3.92 * p.std, rel=0.6)


def test_it_depends_on_the_seed_alone(actual: Robot):
    data = measured(actual, 1)
    one, same, other = (
        deviations(ec.calibrate(arm(), data, elastic=LINEAR, bootstrap=20, seed=seed)) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one, other)


def test_twice_the_noise_gives_twice_the_deviations(actual: Robot):
    one, two = (
        deviations(ec.calibrate(arm(), measured(actual, 1, noise=noise), elastic=LINEAR, bootstrap=20))
        for noise in (2e-6, 4e-6)
    )
    np.testing.assert_allclose(two, 2.0 * one, rtol=0.02)


@pytest.mark.parametrize("kinds", [("position", "orientation"), ("distance",)])
def test_all_kinds_of_observations_have_it(actual: Robot, kinds: tuple[str, ...]):
    data = measured(actual, 2, 60, kinds=kinds, noise_angle=1e-4)
    linear, found = (ec.calibrate(arm(), data, bootstrap=n) for n in (0, 30))
    assert np.median(deviations(found) / deviations(linear)) == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("law", ["hinge", "step"])
def test_transition_torques_have_it(law: str, actual: Robot):
    bent = replace(actual, elastic={"2.theta": Compliance(law, *SPRINGS["2"])})
    result = ec.calibrate(arm(), measured(bent, 1, 40), elastic={"2": law}, bootstrap=20)
    torque = next(p for p in result.parameters if p.name == "2.theta.transition_torque")
    assert torque.interval[0] < SPRINGS["2"][1] < torque.interval[1]
    assert 0.0 < torque.std < 30.0
    assert result.elastic[0].transition_std == torque.std
    if law == "step":
        low, high = result.elastic[0].transition.gap
        assert torque.interval[0] <= low < high <= torque.interval[1]


def test_a_compliance_held_at_zero_takes_no_part(actual: Robot):
    rigid = replace(actual, elastic={})
    for seed in range(4):
        result = ec.calibrate(
            arm(), measured(rigid, seed), elastic={"2": "linear", "3": "linear"}, non_negative=True, bootstrap=20
        )
        for p in result.parameters:
            if p.name.endswith(".c") and p.interval is not None:
                assert p.interval[0] >= -1e-20


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"bootstrap": 5}, "at least 20"),
        ({"bootstrap": 50, "transmission": 4}, "have priors, which a bootstrap knows nothing of"),
        ({"bootstrap": 50, "prior": True}, "have priors, which a bootstrap knows nothing of"),
    ],
)
def test_what_tells_nothing_is_refused(actual: Robot, options: dict[str, int], message: str):
    with pytest.raises(ec.InputError, match=message):
        ec.calibrate(arm(), measured(actual, 1), **options)


def test_where_not_all_is_identifiable_there_is_none(actual: Robot):
    result = ec.calibrate(arm(), measured(actual, 1, 6), bootstrap=20)
    assert (result.status, result.bootstrap) == ("not_identifiable", None)


def test_the_command(desk: Desk):
    save_simulated(desk.folder)
    out = desk.done("calibrate robot.toml fit.csv --elastic 2,3 --bootstrap 20 -o result")
    assert "bootstrap of 20 fits" in " ".join(out.split())
    saved = json.loads((desk.folder / "result" / "result.json").read_text())
    assert saved["bootstrap"] == {"fits": 20, "failed": 0}
    assert saved["settings"]["bootstrap"] == 20
    plain = json.loads(desk.done("calibrate robot.toml fit.csv --elastic 2,3 --json"))
    assert plain["bootstrap"] is None
    assert "at least 20" in desk.refused("calibrate robot.toml fit.csv --bootstrap 7")[0]
