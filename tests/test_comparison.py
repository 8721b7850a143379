"""Comparison of models: the rule finds the law that is there, and counts what it costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.comparison import MODELS, PENALTY, Comparison, compare
from elastocal.errors import InputError
from elastocal.identification import calibrate
from elastocal.measurements import Measurements
from elastocal.robot import Compliance, Robot
from elastocal.simulation import random_poses, simulate
from support.robots import arm, placed

NOISE = 3e-5

SPRINGS = {
    "rigid": {},
    "linear": {"2.theta": Compliance("linear", (4e-6,)), "3.theta": Compliance("linear", (9e-6,))},
    "step": {"2.theta": Compliance("step", (5e-6, 2e-6), 330.0), "3.theta": Compliance("step", (1e-5, 4e-6), 90.0)},
    "hinge": {"2.theta": Compliance("hinge", (5e-6, 2e-6), 330.0), "3.theta": Compliance("hinge", (1e-5, 4e-6), 90.0)},
}


def actual_arm(kind: str, seed: int) -> Robot:
    rng = np.random.default_rng(seed)
    deltas = {e.name: 1e-3 * rng.standard_normal() for row in arm().row_elements for e in row}
    return replace(placed(arm().displaced(deltas), rng), elastic=SPRINGS[kind])


def measured(kind: str, seed: int, **options: object) -> Measurements:
    actual = actual_arm(kind, seed)
    return simulate(actual, random_poses(actual, 60, seed), noise=NOISE, seed=seed, **options)


def compared(kind: str, seed: int, **options: object) -> Comparison:
    return compare(arm(), measured(kind, seed), elastic=("2", "3"), folds=None, **options)


@pytest.mark.parametrize("kind", SPRINGS)
def test_the_law_that_is_there_is_recommended(kind: str):
    assert [compared(kind, seed).recommended for seed in range(3)] == [kind] * 3


def test_transition_torques_are_counted_as_parameters():
    counts = {m.name: m.parameters for m in compared("step", 0).models}
    rigid = counts["rigid"]
    expected = {"rigid": rigid, "linear": rigid + 2, "step": rigid + 6, "hinge": rigid + 6, "cubic": rigid + 4}
    assert counts == expected


def test_criteria_are_those_of_normal_residuals():
    model = compared("linear", 1, models=["linear"]).models[0]
    data = measured("linear", 1)
    found = calibrate(arm(), data, elastic={"2": "linear", "3": "linear"}).errors.calibrated.position
    n, p = 180, model.parameters
    deviance = n * np.log(np.mean(found**2)) + n
    assert model.coordinates == n
    assert model.deviance == pytest.approx(deviance, rel=1e-9)
    assert model.aicc == pytest.approx(deviance + 2 * p + 2 * p * (p + 1) / (n - p - 1), rel=1e-9)
    assert model.bic == pytest.approx(deviance + p * np.log(n), rel=1e-9)
    assert model.criterion == pytest.approx(deviance + PENALTY * p * np.log(n), rel=1e-9)


def test_stated_deviations_weigh_in_the_likelihood():
    plain, stated = (
        compare(arm(), measured("step", 2, state_sigma=told), elastic=("2", "3"), folds=None) for told in (False, True)
    )
    assert plain.recommended == stated.recommended == "step"
    linear, step = (next(m for m in stated.models if m.name == name) for name in ("linear", "step"))
    assert step.deviance < linear.deviance


def test_models_nest_so_that_more_of_them_never_fits_worse():
    deviance = {m.name: m.deviance for m in compared("linear", 3).models}
    assert deviance["linear"] <= deviance["rigid"]
    for name in ("step", "hinge", "cubic"):
        assert deviance[name] <= deviance["linear"] + 1e-6


def test_errors_on_unseen_poses_are_larger_than_residuals_and_calls_are_counted():
    calls = []
    found = compare(
        arm(),
        measured("step", 4),
        elastic=("2", "3"),
        models=["linear", "step"],
        folds=5,
        on_fit=lambda done, total: calls.append((done, total)),
    )
    assert calls == [(i, 12) for i in range(1, 13)]
    for model in found.models:
        assert model.cross_validated.mean > model.residual.mean
        assert model.cross_validated.n == 60


def test_unknown_models_and_no_elements_are_refused():
    with pytest.raises(InputError, match=r"no model 'hing'; did you mean 'hinge'\? \(valid: rigid, linear, step"):
        compare(arm(), measured("rigid", 0), elastic=("2",), models=["hing"])
    with pytest.raises(InputError, match="expected at least one element"):
        compare(arm(), measured("rigid", 0), elastic=())
    with pytest.raises(InputError, match="no element '9'"):
        compare(arm(), measured("rigid", 0), elastic=("9",), models=["rigid", "linear"])


def test_a_model_that_cannot_be_identified_is_shown_and_left_out():
    few = measured("linear", 5).take(np.arange(10))
    found = compare(arm(), few, elastic=("2", "3"), folds=None)
    assert {m.name: m.status for m in found.models}["step"] == "not_identifiable"
    assert found.recommended in ("rigid", "linear", None)
    assert any(warning.startswith("step: not identifiable") for warning in found.warnings)


def test_all_models_are_the_default():
    assert tuple(m.name for m in compared("rigid", 1).models) == MODELS
