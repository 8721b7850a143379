"""Compliances kept from becoming negative, on robots some of whose joints are rigid."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain, combinations

import numpy as np
import pytest

from elastocal.identification import CalibrationResult, calibrate
from elastocal.identification.bounds import fit_non_negative
from elastocal.identification.transition import Problem, Trial, fit_anew
from elastocal.measurements import Measurements
from elastocal.robot import Compliance
from support.calibrations import measured
from support.robots import arm
from support.transitions import actual_arm, problem

JOINTS = "23456"

SEEDS = range(8)


def data_of(seed: int) -> Measurements:
    """Of an arm that gives way at joints 2 and 3 only, so noisy that the others may seem to, either way."""
    elastic = {"2.theta": Compliance("linear", (3e-6,)), "3.theta": Compliance("linear", (5e-6,))}
    return measured(replace(actual_arm(arm(), {}), elastic=elastic), 40, seed, noise=1e-4)


def fitted(data: Measurements, joints: str = JOINTS, **options: object) -> CalibrationResult:
    return calibrate(arm(), data, elastic=dict.fromkeys(joints, "linear"), **options)


def compliances(result: CalibrationResult) -> dict[str, float]:
    return {element.element[0]: element.coefficients[0] for element in result.elastic}


def held(result: CalibrationResult) -> str:
    """The joints whose compliance is held at zero."""
    rows = [p for p in result.parameters if p.name.endswith(".c") and p.std is None]
    assert all(p.identified == 0.0 for p in rows)
    assert {(p.verdict, p.reason) for p in rows} <= {
        ("insignificant", "it is held at zero: it would come out negative")
    }
    return "".join(p.name[0] for p in rows)


@pytest.mark.parametrize("seed", SEEDS)
def test_none_is_negative_and_those_held_would_be_when_let_go(seed: int):
    """Kuhn and Tucker's conditions: the held ones are at zero, and letting any of them go would take it below."""
    data = data_of(seed)
    result = fitted(data, non_negative=True)
    assert result.status == "converged"
    assert min(compliances(result).values()) >= 0.0
    free = [joint for joint in JOINTS if joint not in held(result)]
    for joint in held(result):
        assert compliances(fitted(data, "".join([*free, joint])))[joint] < 0.0


@pytest.mark.parametrize("seed", SEEDS[:5])
def test_no_other_choice_of_those_held_fits_better(seed: int):
    data = data_of(seed)
    choices = chain.from_iterable(combinations("456", count) for count in range(4))
    best = np.inf
    for choice in choices:
        result = fitted(data, "".join(joint for joint in JOINTS if joint not in choice))
        if min(compliances(result).values()) >= 0.0:
            best = min(best, result.residuals["calibrated"].rms)
    assert fitted(data, non_negative=True).residuals["calibrated"].rms == pytest.approx(best, rel=1e-9)


def test_the_seeds_above_have_none_one_and_more_to_hold():
    free = [min(compliances(fitted(data_of(seed))).values()) for seed in SEEDS]
    assert min(free) < 0.0 < max(free)
    assert {len(held(fitted(data_of(seed), non_negative=True))) for seed in SEEDS} >= {0, 1, 2}


@pytest.mark.parametrize("seed", [seed for seed in SEEDS if seed in (0, 1)])
def test_where_all_are_positive_nothing_changes(seed: int):
    free, bounded = fitted(data_of(seed)), fitted(data_of(seed), non_negative=True)
    assert held(bounded) == ""
    assert compliances(bounded) == compliances(free)
    np.testing.assert_array_equal(bounded.covariance, free.covariance)
    assert bounded.warnings == free.warnings


def test_those_held_are_told_and_count_as_not_identified():
    free, bounded = fitted(data_of(2)), fitted(data_of(2), non_negative=True)
    assert len(held(bounded)) == 2
    assert len(bounded.names) == len(free.names) - 2
    told = [warning for warning in bounded.warnings if "held at zero" in warning]
    assert [warning.split()[1] for warning in told] == [f"{joint}.theta.c" for joint in held(bounded)]
    assert not any("negative" in warning for warning in bounded.warnings if warning not in told)
    assert any("is negative" in w or "zero within its uncertainty" in w for w in free.warnings)
    assert (bounded.settings["non_negative"], free.settings["non_negative"]) == (True, False)


def test_one_that_was_held_too_soon_is_let_go():
    """The first fit is of data that mislead: of a robot whose third joint rises under its load."""
    sinking, rising = ({"3.theta": Compliance("linear", (c,))} for c in (5e-6, -5e-6))
    actual = actual_arm(arm(), {})
    data, misleading = (measured(replace(actual, elastic=e), 40, 0, noise=1e-5) for e in (sinking, rising))
    fitted_names = []

    def fit(posed: Problem) -> Trial:
        fitted_names.append(posed.names)
        return fit_anew(posed if len(fitted_names) > 1 else replace(posed, data=misleading))

    trial, still_held = fit_non_negative(problem(arm(), data, {"3": "linear"}), fit)
    assert [("3.theta.c" in names) for names in fitted_names] == [True, False, True]
    assert still_held == ()
    found = trial.model.displaced(trial.solution.displacements).elastic["3.theta"].coefficients
    assert found == pytest.approx((5e-6,), rel=0.01)


def test_the_change_of_a_cubic_may_be_negative():
    elastic = {"2.theta": Compliance("cubic", (4e-6, -6e-12)), "3.theta": Compliance("linear", (5e-6,))}
    actual = replace(actual_arm(arm(), {}), elastic=elastic)
    data = measured(actual, 60, 0, noise=1e-5)
    result = calibrate(arm(), data, elastic={"2": "cubic", "3": "linear"}, non_negative=True)
    c1, c3 = result.elastic[0].coefficients
    assert c1 == pytest.approx(4e-6, rel=0.05)
    assert c3 == pytest.approx(-6e-12, rel=0.05)


def test_a_compliance_that_the_robot_file_knows_is_held_at_zero_too():
    """What is held is the compliance, not its change."""
    data = data_of(2)
    joints = held(fitted(data, non_negative=True))
    known = {f"{joint}.theta": Compliance("linear", (2e-6,)) for joint in JOINTS}
    result = calibrate(replace(arm(), elastic=known), data, elastic=dict.fromkeys(JOINTS, "linear"), non_negative=True)
    assert held(result) == joints
    assert [result.robot.elastic[f"{joint}.theta"].coefficients for joint in joints] == [(0.0,)] * len(joints)
    expected = compliances(fitted(data, non_negative=True))
    for joint, value in compliances(result).items():
        assert value == pytest.approx(expected[joint], rel=1e-5)


def test_steps_and_hinges_that_stay_positive_are_as_without_bounds():
    laws = {"2": "step", "3": "hinge"}
    data = measured(actual_arm(arm(), laws), 60, 0, noise=3e-5)
    free, bounded = (calibrate(arm(), data, elastic=laws, non_negative=flag) for flag in (False, True))
    assert [e.coefficients for e in bounded.elastic] == [e.coefficients for e in free.elastic]
    assert [e.transition_torque for e in bounded.elastic] == [e.transition_torque for e in free.elastic]
