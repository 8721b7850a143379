"""Cross-validation: every row is judged once, by a fit that has not seen its pose."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.cross_validation import cross_validate
from elastocal.errors import EquilibriumError, InputError
from elastocal.identification import residuals
from elastocal.measurements import Measurements, folded, repeats
from elastocal.robot import Robot
from elastocal.simulation import random_poses, simulate
from support.robots import arm, placed


def repeated(seed: int, poses: int = 30) -> Measurements:
    """Measurements of an arm, some poses up to four times."""
    rng = np.random.default_rng(seed)
    robot = placed(arm(), rng)
    q = random_poses(robot, poses, seed)[rng.integers(0, poses, 3 * poses)]
    return simulate(robot, q, noise=1e-4, seed=seed)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("folds", [2, 5, 10])
def test_folds_are_of_about_equal_size_and_divide_no_pose(seed: int, folds: int):
    data = repeated(seed)
    part, pose = folded(data, folds, seed), repeats(data)
    assert set(part.tolist()) == set(range(folds))
    for number in np.unique(pose):
        assert len(set(part[pose == number].tolist())) == 1
    largest = np.bincount(pose).max()
    assert np.abs(np.bincount(part) - len(data) / folds).max() <= largest


def test_the_same_seed_makes_the_same_folds_and_another_one_others():
    data = repeated(0)
    np.testing.assert_array_equal(folded(data, 5, 3), folded(data, 5, 3))
    assert (folded(data, 5, 3) != folded(data, 5, 4)).any()


def test_every_row_is_predicted_by_the_robot_identified_without_its_fold():
    data, truth = repeated(1), placed(arm(), np.random.default_rng(1))
    part = folded(data, 5, 0)
    robots = [truth.displaced({"2.a": 1e-3 * (k + 1)}) for k in range(5)]
    seen = []

    def identify(rows: Measurements) -> Robot:
        seen.append(len(rows))
        return robots[len(seen) - 1]

    found = cross_validate(identify, data, folds=5)
    expected = np.concatenate([residuals(robots[k], data.take(np.flatnonzero(part == k))).norms for k in range(5)])
    assert found.n == len(data)
    assert found.mean == pytest.approx(expected.mean(), rel=1e-12)
    assert found.max == expected.max()
    assert seen == [int((part != k).sum()) for k in range(5)]


def test_angles_are_judged_where_orientations_are_measured():
    robot = placed(arm(), np.random.default_rng(2))
    data = simulate(robot, random_poses(robot, 20, 2), kinds=("position", "orientation"))
    found = cross_validate(lambda _: robot.displaced({"tool.rx": 1e-3}), data, folds=4)
    assert found.angle.mean == pytest.approx(1e-3, rel=1e-9)


def test_a_robot_that_does_not_settle_has_infinite_error():
    def identify(_: Measurements) -> Robot:
        raise EquilibriumError("2.theta", 0)

    assert cross_validate(identify, repeated(3), folds=3).mean == np.inf


@pytest.mark.parametrize("folds", [0, 1, 31])
def test_fewer_poses_than_folds_are_refused(folds: int):
    data = repeated(4).take(np.arange(30))
    with pytest.raises(InputError, match=f"folds is {folds}: expected at least 2"):
        cross_validate(lambda _: arm(), data, folds=folds)
