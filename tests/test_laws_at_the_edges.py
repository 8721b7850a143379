"""Laws where little is left to identify: held compliances, few loads, weak coefficients, many rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.errors import InputError
from elastocal.identification import calibrate
from elastocal.identification.transition.grid import load_grid
from elastocal.measurements import Measurements
from elastocal.robot import Compliance
from elastocal.simulation import random_poses, simulate
from support.robots import arm, placed


def measured(springs: dict[str, Compliance], seed: int, poses: int = 40, noise: float = 1e-4) -> Measurements:
    actual = replace(placed(arm(), np.random.default_rng(seed)), elastic=springs)
    return simulate(actual, random_poses(actual, poses, seed), noise=noise, seed=seed)


LINEAR = {"2.theta": Compliance("linear", (2e-6,)), "3.theta": Compliance("linear", (4e-6,))}


@pytest.mark.parametrize("seed", range(6))
def test_a_law_with_a_compliance_held_at_zero_is_told_as_any_other(seed: int):
    result = calibrate(arm(), measured(LINEAR, seed), elastic={"2": "step", "4": "step"}, non_negative=True)
    values = [c for element in result.elastic for c in element.coefficients]
    assert min(values) >= 0.0
    assert all(np.isfinite(e.transition_std) for e in result.elastic)


def test_a_hinge_with_too_few_loads_has_one_torque_and_a_finite_deviation():
    result = calibrate(arm(), measured(LINEAR, 1, poses=6), elastic={"2": "hinge"})
    assert result.status == "not_identifiable"
    assert np.isfinite(result.elastic[0].transition_torque)


def test_a_cubic_on_the_wrist_is_seen_though_its_loads_are_small():
    springs = {"5.theta": Compliance("cubic", (4e-5, -1e-7))}
    result = calibrate(arm(), measured(springs, 2, poses=60, noise=1e-5), elastic={"5": "cubic"})
    verdicts = {p.name: p.verdict for p in result.parameters if p.name.startswith("5.theta.c")}
    assert verdicts == {"5.theta.c1": "identified", "5.theta.c3": "identified"}


@pytest.mark.parametrize("option", ["identify", "fix"])
def test_a_pattern_of_transition_torques_alone_is_refused(option: str):
    with pytest.raises(InputError, match="give them with --transition to hold them"):
        calibrate(arm(), measured(LINEAR, 3), elastic={"2": "step"}, **{option: ["2.theta.transition_torque"]})


def test_loads_however_dense_keep_their_torques():
    loads = np.abs(np.sin(np.random.default_rng(0).uniform(0.0, 7.0, 200_000)))
    grid = load_grid(loads, smooth=False)
    assert len(grid.torques) == 1000
    assert np.diff(grid.torques).max() < 0.01


def test_a_step_found_in_a_linear_joint_is_called_insignificant():
    verdicts = []
    for seed in range(10):
        result = calibrate(arm(), measured(LINEAR, seed, noise=3e-5), elastic={"2": "step", "3": "linear"})
        verdicts.append(next(p.verdict for p in result.parameters if p.name == "2.theta.transition_torque"))
    assert verdicts.count("insignificant") >= 8
