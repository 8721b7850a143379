"""Rows that are held out, and rows that belong together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.errors import InputError
from elastocal.identification import calibrate
from elastocal.measurements import SAME_POSE, concatenate, repeats, split
from support.calibrations import measured
from support.robots import arm, placed


def data(count: int = 50, seed: int = 0):
    return measured(placed(arm(), np.random.default_rng(0)), count, seed, noise=1e-5)


def test_joints_that_agree_are_one_pose_also_in_a_chain():
    q = np.zeros((5, 6))
    q[1] += 0.9 * SAME_POSE
    q[2] += 1.8 * SAME_POSE
    q[3, 2] = 1.1 * SAME_POSE + 1.8 * SAME_POSE
    q[4] = 1.0
    assert repeats(replace(data(5), q=q)).tolist() == [0, 0, 0, 1, 2]


def test_a_shared_pose_number_makes_one_pose_of_joints_that_differ():
    numbered = replace(data(4), pose=np.array([7, -1, 7, -1]))
    groups = repeats(numbered)
    assert groups[0] == groups[2]
    assert len(set(groups.tolist())) == 3


def test_pose_numbers_of_two_files_stay_apart():
    a, b = (replace(data(2, seed), pose=np.array([0, 0])) for seed in (0, 1))
    groups = repeats(concatenate([a, b]))
    assert groups[0] == groups[1] != groups[2] == groups[3]


@pytest.mark.parametrize("fraction", [0.1, 0.3, 0.7])
def test_split_holds_out_about_the_fraction_and_whole_poses(fraction):
    twice = concatenate([data(200), data(200)])
    fitted, held = split(twice, fraction, 3)
    assert len(held) == pytest.approx(fraction * 400, abs=4)
    assert sorted([*fitted, *held]) == list(range(400))
    assert not set(repeats(twice)[fitted]) & set(repeats(twice)[held])


def test_the_seed_decides_the_split():
    first, again, other = (split(data(), 0.3, seed)[1].tolist() for seed in (1, 1, 2))
    assert first == again != other


def test_held_out_rows_are_not_used():
    rows = data(80)
    result = calibrate(arm(), rows, holdout=0.4, seed=1)
    fitted, held = split(rows, 0.4, 1)
    assert result.residuals["held_out"].n == len(held)
    alone = calibrate(arm(), rows.take(fitted), held_out=rows.take(held))
    assert alone.residuals["held_out"] == result.residuals["held_out"]
    spoilt = rows.position.copy()
    spoilt[held] += 1.0
    assert calibrate(arm(), replace(rows, position=spoilt), holdout=0.4, seed=1).robot == result.robot


@pytest.mark.parametrize("fraction", [0.0, 1.0, -0.1, 30.0])
def test_a_fraction_that_is_none_is_refused(fraction):
    with pytest.raises(InputError, match="between 0 and 1"):
        calibrate(arm(), data(), holdout=fraction)


def test_both_ways_of_holding_out_at_once_are_refused():
    with pytest.raises(InputError, match="give one of the two"):
        calibrate(arm(), data(), holdout=0.3, held_out=data())
