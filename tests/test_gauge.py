"""Which parameters a kind of measurement can tell: theorems as numbers, and reasons in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.identification import calibrate, choose_gauge
from elastocal.identification.request import requested
from elastocal.parameters import Group, parameters_of
from elastocal.robot import Frame, Robot
from support.calibrations import ALL_LINEAR, actual_in_gauge, gauge_of, measured
from support.robots import arm, random_dh_robot

FULL_POSE, POINT = ("position", "orientation"), ("position",)


def opened(robot: Robot) -> Robot:
    """The robot with base and tool to be identified."""
    return replace(robot, base=Frame(), tool=Frame())


@pytest.mark.parametrize(("kinds", "rank"), [(FULL_POSE, 30), (POINT, 27)])
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_rigid_six_joint_arm_has_rank_30_with_full_poses_and_27_with_one_point(convention, kinds, rank):
    robots = [arm(), *(opened(random_dh_robot(np.random.default_rng(seed), convention)) for seed in range(5))]
    assert [len(gauge_of(robot, kinds).kept) for robot in robots] == [rank] * len(robots)


@pytest.mark.parametrize("seed", range(6))
def test_rank_is_4_for_each_revolute_2_for_each_prismatic_joint_and_6(seed):
    robot = opened(random_dh_robot(np.random.default_rng(seed), "modified-dh", joints=6, prismatic=0.4))
    revolute = sum(row.joint == "revolute" for row in robot.rows)
    assert len(gauge_of(robot, FULL_POSE).kept) == 4 * revolute + 2 * (6 - revolute) + 6


@pytest.mark.parametrize(("kinds", "rank"), [(FULL_POSE, 30), (POINT, 27)])
def test_data_confirm_the_rank(kinds, rank):
    result = calibrate(
        arm(), measured(actual_in_gauge(arm(), gauge_of(arm(), kinds), np.random.default_rng(0)), 60, 0, kinds=kinds)
    )
    assert (result.observability.rank, result.observability.parameters) == (rank, rank)


def test_known_frames_make_room_for_the_first_and_last_rows():
    robot = replace(arm(), base=Frame(known=True), tool=Frame((0.1, 0.0, 0.2), known=True))
    kept = gauge_of(robot, FULL_POSE).kept
    assert len(kept) == 26  # all six of row 1, four of each other: what a tool beyond the last axis adds is known
    assert {"1.theta", "6.theta"} <= set(kept)
    assert not any(name.startswith(("base", "tool")) for name in kept)


def test_frames_and_joint_offsets_are_kept_before_lengths_and_these_before_twists():
    gauge, groups = gauge_of(arm(), FULL_POSE), {name: p.group for name, p in parameters_of(arm()).items()}
    for name, dropped in gauge.dropped.items():
        assert dropped.verdict == "dependent"
        assert max(groups[partner] for partner in dropped.partners) <= groups[name]
    assert "1.theta" in gauge.dropped
    assert "base.rz" in gauge.dropped["1.theta"].partners


def test_gauge_does_not_depend_on_the_poses_or_their_number():
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), np.random.default_rng(1))
    gauges = []
    for seed, count in ((0, 3), (1, 60), (2, 400)):
        data = measured(actual, count, seed)
        gauges.append(choose_gauge(arm(), data, requested(arm(), ())))
    assert gauges[0].kept == gauges[1].kept == gauges[2].kept


def test_compliance_about_a_vertical_axis_is_unobservable_with_that_reason():
    gauge = gauge_of(arm(), POINT, ALL_LINEAR)
    assert gauge.dropped["1.theta.c"].verdict == "unobservable"
    assert "axis is vertical" in gauge.dropped["1.theta.c"].reason
    assert [name for name in gauge.kept if name.endswith(".c")] == [f"{i}.theta.c" for i in range(2, 7)]


def test_compliance_of_the_first_joint_is_observable_where_gravity_is_not_along_its_axis():
    on_the_wall = replace(arm(), gravity=(9.81, 0.0, 0.0))
    assert "1.theta.c" in gauge_of(on_the_wall, POINT, ALL_LINEAR).kept


def test_compliance_of_an_unloaded_joint_is_unobservable():
    balanced = replace(arm(tool_mass=0.0), rows=(*arm().rows[:5], replace(arm().rows[5], com=(0.0, 0.0, 0.1))))
    dropped = gauge_of(balanced, POINT, {"6": "linear"}).dropped["6.theta.c"]
    assert dropped.verdict == "unobservable"
    assert "balanced about its axis" in dropped.reason


def test_tool_orientation_is_unobservable_from_one_point_and_the_last_offset_depends_on_the_tool():
    gauge = gauge_of(arm(), POINT)
    assert {gauge.dropped[f"tool.{key}"].verdict for key in ("rx", "ry", "rz")} == {"unobservable"}
    assert "measured point stays where it is" in gauge.dropped["tool.rx"].reason
    assert set(gauge.dropped["6.theta"].partners) == {"tool.tx", "tool.ty"}


def test_distances_do_not_tell_how_the_instrument_is_turned():
    gauge = gauge_of(arm(), ("distance",))
    assert len(gauge.kept) == 24
    assert {gauge.dropped[f"base.{key}"].verdict for key in ("rx", "ry", "rz")} == {"dependent"}


def test_axes_that_are_parallel_keep_one_offset_along_them_and_the_twist_between_them():
    kept = gauge_of(arm(), FULL_POSE).kept  # axes 2 and 3 are parallel
    assert ("2.d" in kept) + ("3.d" in kept) == 1
    assert {"3.alpha", "3.beta"} <= set(kept)


def test_rounded_angles_change_nothing():
    rounded = [replace(row, geometry={k: round(v, 4) for k, v in row.geometry.items()}) for row in arm().rows]
    assert gauge_of(replace(arm(), rows=tuple(rounded)), FULL_POSE).kept == gauge_of(arm(), FULL_POSE).kept


def test_effects_say_how_far_a_unit_moves_the_target():
    effects = gauge_of(arm(), POINT).effects
    assert effects["base.tx"] == pytest.approx(1.0)
    assert 0.3 < effects["2.theta"] < 2.0


def test_targets_are_kept_before_the_tool_and_both_are_counted_once():
    robot = replace(arm(), targets={"a": Frame(), "b": Frame()})
    wished = requested(robot, ())
    data = measured(
        replace(robot, targets={"a": Frame((0.1, 0.0, 0.0)), "b": Frame((0.0, 0.1, 0.0))}), 3, 0, target="a"
    )
    gauge = choose_gauge(robot, data, wished)
    assert {f"target.a.{key}" for key in ("tx", "ty", "tz")} <= set(gauge.kept)
    assert gauge.dropped["tool.tx"].verdict == "dependent"
    assert gauge.dropped["target.b.tx"].reason == "no measurement involves it"
    assert parameters_of(robot)["target.a.tx"].group == Group.TARGET
