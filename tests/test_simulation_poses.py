"""Poses at random: within limits, above the floor, where the instrument sees them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.prediction import predict
from elastocal.robot import Frame, Payload, Robot
from elastocal.simulation import Region, random_poses
from support.robots import arm, placed, random_dh_robot

REGIONS = {
    "floor": Region(floor=0.3),
    "box": Region(box=((-3.0, 3.0), (-3.0, 2.5), (-2.0, 3.0))),
    "range": Region(range=(2.0, 3.5)),
    "cone": Region(cone=0.2),
    "all": Region(0.1, ((-4.0, 4.0), (-3.0, 4.0), (-2.0, 4.0)), (1.5, 4.5), 0.4),
}


@pytest.fixture(scope="module")
def robot() -> Robot:
    """An arm, a little soft, some 3 m from a tilted instrument."""
    there = placed(arm(elastic=True), np.random.default_rng(0))
    return replace(there, base=Frame((2.0, -1.5, 1.0), (0.5, -0.3, 2.0), known=True), loads={"heavy": Payload(20.0)})


@pytest.mark.parametrize("seed", range(3))
def test_poses_are_within_limits_and_fill_them(seed: int):
    robot = random_dh_robot(np.random.default_rng(seed), "modified-dh", prismatic=0.3)
    rows = tuple(replace(row, limits=(-0.3 * i, 0.2 * i)) if i % 2 else row for i, row in enumerate(robot.rows, 1))
    q = random_poses(replace(robot, rows=rows), 5000, seed)
    for positions, row in zip(q.T, rows, strict=True):
        low, high = row.limits or ((-np.pi, np.pi) if row.joint == "revolute" else (-0.5, 0.5))
        assert low <= positions.min() < low + 0.01 * (high - low)
        assert high >= positions.max() > high - 0.01 * (high - low)


@pytest.mark.parametrize("name", REGIONS)
def test_every_pose_keeps_to_the_region_and_to_the_limits(robot: Robot, name: str):
    region = REGIONS[name]
    q = random_poses(robot, 300, 1, region=region, load="heavy")
    assert q.shape == (300, 6)
    limits = np.array([row.limits for row in robot.joints])
    assert ((q >= limits[:, 0]) & (q <= limits[:, 1])).all()
    position = predict(robot, q, load="heavy")[0]
    distance = np.linalg.norm(position, axis=1)
    if region.floor is not None:
        in_base = (position - robot.base.translation) @ robot.base.rotation
        assert in_base[:, 2].min() > region.floor
    if region.box is not None:
        low, high = np.array(region.box).T
        assert ((position >= low) & (position <= high)).all()
    if region.range is not None:
        assert region.range[0] <= distance.min() < distance.max() <= region.range[1]
    if region.cone is not None:
        centre = predict(robot, random_poses(robot, 20_000, 5), load="heavy")[0].mean(axis=0)
        away = np.arccos(position @ centre / distance / np.linalg.norm(centre))
        assert 0.9 * region.cone < away.max() < 1.1 * region.cone


@pytest.mark.parametrize("count", [1, 7, 400])
def test_the_same_seed_gives_the_same_poses_and_no_region_costs_none(robot: Robot, count: int):
    one, again, other = (random_poses(robot, count, seed, region=REGIONS["all"]) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    assert (one != other).all()
    np.testing.assert_array_equal(random_poses(robot, count, 1, region=Region()), random_poses(robot, count, 1))


def test_limits_are_those_of_one_robot_and_the_target_is_that_of_the_other(robot: Robot):
    narrow = replace(robot, base=Frame(), rows=tuple(replace(row, limits=(-0.5, 0.5)) for row in robot.rows))
    q = random_poses(narrow, 100, 1, region=Region(range=(2.0, 2.5)), actual=robot)
    assert np.abs(q).max() <= 0.5
    distance = np.linalg.norm(predict(robot, q)[0], axis=1)
    assert 2.0 <= distance.min() < distance.max() <= 2.5


def test_a_station_and_a_target_have_their_own_region(robot: Robot):
    there = replace(robot, stations={"north": Frame((0.0, 0.0, -1.0))}, targets={"far": Frame((0.0, 0.0, 0.5))})
    q = random_poses(there, 100, 1, region=Region(floor=1.0), station="north", target="far")
    assert predict(there, q, station="north", target="far")[0][:, 2].min() > 0.0


def test_a_region_out_of_reach_says_what_rejected_how_many(robot: Robot):
    with pytest.raises(ec.InputError) as raised:
        random_poses(robot, 5, 1, region=Region(floor=0.0, range=(0.0, 0.1)))
    (fault,) = raised.value.faults
    assert fault.startswith("found 0 of 5 poses: of 1")
    assert "drawn within the joint limits, range rejects 100 %, floor rejects " in fault
    assert fault.endswith("; widen what rejects most")


@pytest.mark.parametrize(
    ("values", "fault"),
    [
        ({"box": ((0.0, 1.0), (1.0, 1.0), (0.0, 1.0))}, "box: expected the lowest y and then the highest, found 1 m"),
        ({"range": (2.0, 1.0)}, "range: expected the least distance and then the greatest, found 2 m and 1 m"),
        ({"range": (-1.0, 1.0)}, "range: expected the least distance and then the greatest, found -1 m and 1 m"),
        ({"cone": 0.0}, "cone: expected a half angle between 0 and 180 deg, found 0 deg"),
        ({"cone": 4.0}, "cone: expected a half angle between 0 and 180 deg, found 229"),
    ],
)
def test_a_region_that_cannot_be_is_refused(values: dict[str, object], fault: str):
    with pytest.raises(ec.InputError) as raised:
        Region(**values)
    assert raised.value.faults[0].startswith(fault)
