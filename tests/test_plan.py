"""Plans: they promise what `calibrate` then says, and do not hang on what does not matter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.design import Surroundings, draw_candidates
from elastocal.measurements import Labels, Measurements, concatenate
from elastocal.robot import Compliance, Frame, Payload, Robot
from elastocal.simulation import simulate
from support.robots import arm

SOFT = {"2": "linear", "3": "linear"}
TOOL = Frame((0.1, -0.05, 0.15))


def candidates(count: int = 600, seed: int = 0) -> np.ndarray:
    return ec.random_poses(arm(), count, seed)


def placed_at(base: Frame, **changes: object) -> Robot:
    return replace(arm(), base=base, tool=TOOL, **changes)


@pytest.mark.parametrize("kinds", [("position",), ("position", "orientation")])
def test_what_the_plan_says_is_what_calibrate_says_of_measurements_at_its_poses(kinds: tuple[str, ...]):
    """The same parameters, indices and standard deviations, on the robot that was planned for."""
    base = Frame((2.0, 1.0, 0.3), (0.0, 0.1, 2.0))
    nominal = placed_at(base)
    plan = ec.select_poses(nominal, candidates(), 40, elastic=SOFT, kinds=kinds, noise=2e-5, noise_angle=5e-5)
    frames = {"base": replace(base, known=True), "tool": replace(TOOL, rpy=(0.0, 0.0, 0.0), known=True)}
    actual = nominal.with_frames(frames)
    data = simulate(actual, plan.q, kinds=kinds, noise=2e-5, noise_angle=5e-5, state_sigma=True, seed=3)
    result = ec.calibrate(nominal, data, elastic=SOFT)
    assert tuple(p.name for p in plan.parameters) == result.names
    scale = np.sqrt(max(result.chi2_reduced, 1.0))
    found = {p.name: p.std / scale for p in result.parameters if p.std is not None}
    close = 0.01 if kinds == ("position",) else 0.15  # of two kinds, calibrate estimates their weights anew
    assert {name: std for name, std in plan.std.items() if std is not None} == pytest.approx(found, rel=close)
    assert plan.observability.rank == result.observability.rank == len(plan.parameters)
    assert pytest.approx(result.observability.O2, rel=close) == plan.observability.O2
    if kinds == ("position",):
        for index in ("O1", "O3", "O4", "O5"):
            assert getattr(plan.observability, index) == pytest.approx(getattr(result.observability, index), rel=0.01)
    uncertain = ec.position_uncertainty(result, candidates(400, 5)).from_parameters / scale
    assert plan.accuracy == pytest.approx(np.sqrt((uncertain**2).mean()), rel=0.04 + close)


@pytest.mark.parametrize("criterion", ["O1", "accuracy"])
def test_where_the_instrument_stands_changes_no_choice(criterion: str):
    plans = [
        ec.select_poses(placed_at(base), candidates(300), 14, criterion=criterion, seed=2)
        for base in (
            Frame(),
            Frame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
            Frame((3.0, -2.0, 1.0), (0.5, -0.3, 2.0)),
        )
    ]
    for plan in plans[1:]:
        assert sorted(plan.rows.tolist()) == sorted(plans[0].rows.tolist())
        assert plan.accuracy == pytest.approx(plans[0].accuracy, rel=1e-6)


def test_the_noise_scales_what_is_expected_and_changes_no_choice():
    one, other = (ec.select_poses(arm(), candidates(300), 14, noise=noise) for noise in (1e-5, 5e-5))
    assert np.array_equal(one.rows, other.rows)
    assert other.accuracy == pytest.approx(5.0 * one.accuracy, rel=1e-6)
    assert other.std["2.alpha"] == pytest.approx(5.0 * one.std["2.alpha"], rel=1e-6)


def test_planned_poses_beat_random_ones_and_more_are_better():
    plan = ec.select_poses(arm(), candidates(), 20, criterion="accuracy")
    planned = [point.planned for point in plan.curve if point.planned is not None]
    assert planned == sorted(planned, reverse=True)
    assert all(point.planned < point.random for point in plan.curve if point.planned and point.random)
    assert {20, 60} <= {point.poses for point in plan.curve}
    assert next(p.planned for p in plan.curve if p.poses == 20) == pytest.approx(plan.accuracy)
    assert plan.travel["after"] < plan.travel["before"]
    assert plan.enough in {point.poses for point in plan.curve}


@pytest.mark.parametrize("criterion", ["O1", "O2", "O3", "O4", "O5"])
def test_the_criterion_is_the_index_that_is_best(criterion: str):
    plans = {name: ec.select_poses(arm(), candidates(100), 15, criterion=name) for name in {criterion, "accuracy"}}
    values = {name: getattr(plan.observability, criterion) for name, plan in plans.items()}
    assert values[criterion] > values["accuracy"]


def test_the_same_seed_gives_the_same_plan():
    one, other = (ec.select_poses(arm(), candidates(300), 12, seed=5) for _ in range(2))
    assert replace(one, seconds=0.0).settings == other.settings and np.array_equal(one.q, other.q)
    assert one.curve == other.curve and one.parameters == other.parameters


@pytest.mark.parametrize("law", ["step", "hinge"])
def test_loads_are_spread_so_that_a_search_finds_the_torque(law: str):
    """Wherever it lies: the poses are chosen without knowing it."""
    offered, elastic = candidates(3000), {"2": law, "3": "linear"}
    plan = ec.select_poses(replace(arm(), tool=TOOL), offered, 40, elastic=elastic)
    (found,) = plan.transitions
    assert min(found.below, found.above) >= 10
    assert found.widest_gap < 0.2 * found.highest and found.source == "the median of the candidates' loads"
    for torque in (120.0, 330.0):
        soft = {"2.theta": Compliance(law, (8e-6, 3e-6), torque), "3.theta": Compliance("linear", (4e-6,))}
        known = {"base": Frame((2.0, 1.0, 0.0), (0.0, 0.0, 2.0), known=True), "tool": replace(TOOL, known=True)}
        actual = replace(arm(), elastic=soft).with_frames(known)
        result = ec.calibrate(arm(), simulate(actual, plan.q, noise=1e-5, seed=1), elastic=elastic)
        transition = next(e for e in result.elastic if e.element == "2.theta")
        assert transition.verdict == "identified"
        assert abs(transition.transition_torque - torque) < found.widest_gap


def test_given_torques_are_taken_and_both_sides_measured():
    plan = ec.select_poses(arm(), candidates(), 30, elastic={"2": "step"}, transition=[300.0])
    (found,) = plan.transitions
    assert (found.torque, found.source) == (300.0, "given") and min(found.below, found.above) >= 6
    soft = {"2.theta": Compliance("hinge", (8e-6, 3e-6), 250.0)}
    hinge = ec.select_poses(replace(arm(), elastic=soft), candidates(), 30, elastic={"2": "hinge"})
    assert hinge.transitions[0].torque == 250.0 and hinge.std["2.theta.transition_torque"] > 0.0
    assert "2.theta.transition_torque" not in plan.std


def test_poses_measured_already_count_and_are_not_measured_again():
    actual = replace(arm(), base=Frame(known=True), tool=replace(TOOL, known=True))
    q = candidates()
    before = simulate(actual, q[:12], noise=3e-5, seed=1)
    alone = ec.select_poses(arm(), q, 12)
    more = ec.select_poses(arm(), q, 12, measured=before)
    assert more.accuracy < 0.8 * alone.accuracy and more.measured == 12
    assert not set(more.rows.tolist()) & set(range(12))
    few = ec.select_poses(arm(), q, 1, measured=before)
    assert few.status == "planned" and few.observability.rank == 27


def test_measured_poses_with_stated_deviations_weigh_by_them():
    actual = replace(arm(), base=Frame(known=True), tool=replace(TOOL, known=True))
    q = candidates()
    plans = [
        ec.select_poses(arm(), q[60:], 10, measured=simulate(actual, q[:60], noise=noise, state_sigma=True))
        for noise in (1e-6, 1e-3)
    ]
    assert plans[0].accuracy < 0.1 * plans[1].accuracy


def test_too_few_poses_are_planned_and_told():
    plan = ec.select_poses(arm(), candidates(100), 5)
    assert plan.status == "not_identifiable" and plan.accuracy is None
    assert plan.warnings[0].startswith("5 poses cannot tell 27 parameters: it needs at least 9, and some more")
    assert len(plan.q) == 5 and "not_identifiable" in str(plan)
    assert "1 pose cannot tell" in ec.select_poses(arm(), candidates(100), 1).warnings[0]


def test_candidates_that_do_not_tell_a_parameter_are_told():
    q = candidates(200)
    q[:, 2] = 0.3
    plan = ec.select_poses(arm(), q, 30)
    assert plan.status == "not_identifiable"
    assert plan.warnings[0].startswith("these candidates do not tell ") and "3.theta" in plan.warnings[0]
    assert plan.std["3.theta"] is None


def test_payloads_and_targets_are_chosen_too():
    robot = replace(
        arm(),
        targets={"a": Frame((0.1, 0.0, 0.0)), "b": Frame((0.0, 0.15, 0.05))},
        loads={"heavy": Payload(30.0, (0.0, 0.0, 0.15))},
    )
    offered = draw_candidates(robot, 800, 40, Surroundings(), targets=["a", "b"], loads=[None, "heavy"]).poses
    plan = ec.select_poses(robot, offered, 30, elastic=SOFT)
    assert {(c.target, c.load) for c in plan.poses.combinations} == {
        (target, load) for target in "ab" for load in (None, "heavy")
    }
    assert {"target.a.tx", "target.b.tz", "2.theta.c"} <= set(plan.std)
    changes = (np.diff(plan.poses.target.codes) != 0).sum(), (np.diff(plan.poses.load.codes) != 0).sum()
    assert changes[0] == 1 and changes[1] <= 3
    unloaded = offered.take(np.flatnonzero(offered.load.codes < 0))
    assert plan.std["2.theta.c"] < ec.select_poses(robot, unloaded, 30, elastic=SOFT).std["2.theta.c"]


def test_expected_positions_are_those_of_the_nominal_robot_where_its_frames_are_known():
    robot = placed_at(Frame((2.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    plan = ec.select_poses(robot, candidates(100), 12)
    assert plan.expected == pytest.approx(ec.predict(robot, plan.q)[0], abs=1e-12)
    assert ec.select_poses(arm(), candidates(100), 12).expected is None


def test_distances_are_planned_for_and_hang_on_the_instrument():
    robot = placed_at(Frame((2.5, -1.0, 0.4), (0.0, 0.0, 2.0)))
    plan = ec.select_poses(robot, candidates(400), 60, kinds=("distance",))
    assert plan.status == "planned" and plan.warnings == ()
    lost = ec.select_poses(replace(arm(), tool=TOOL), candidates(200), 40, kinds=("distance",))
    assert any(text.startswith("what a distance tells hangs on where the instrument stands") for text in lost.warnings)


REFUSED = {
    "few": ({"count": 9}, "expected at least 9 candidates to choose 9 poses from, found 8: offer more, or ask for"),
    "none": ({"count": 0}, "expected 1 pose or more to choose, found 0"),
    "criterion": ({"criterion": "o1"}, "no criterion 'o1'; did you mean 'O1'?"),
    "kinds": ({"kinds": ["pose"]}, "no kind 'pose'"),
    "no kind": ({"kinds": []}, "expected something to measure, found no kind (valid: position, orientation, distance)"),
    "noise": ({"noise": 0.0}, "noise: expected a positive number, found 0"),
    "apart": ({"apart": [0.1, 0.1]}, "apart: expected one positive number or 6, found [0.1, 0.1]"),
    "start": ({"start": [0.0]}, "start: expected 6 joint positions, found [0.0]"),
    "elastic": ({"elastic": {"7": "linear"}}, "no element '7'"),
    "fix": ({"fix": ["*"]}, "expected parameters to identify, found none: leave out --fix"),
    "transition": ({"transition": [1.0]}, "transition: expected one torque for each element with a transition (none"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_makes_no_sense_is_refused(case: str):
    options, message = REFUSED[case]
    with pytest.raises(ec.InputError) as caught:
        ec.select_poses(arm(), candidates(8), **{"count": 5, **options})
    assert caught.value.faults[0].startswith(message)


def test_candidates_that_are_none_are_refused():
    bad = candidates(8)
    bad[2, 1] = np.nan
    for given, message in (
        (np.zeros((8, 5)), r"candidates: expected \(poses, 6\) joint positions, found \(8, 5\)"),
        (bad, "candidates: expected numbers, found .* in pose 3"),
        (Measurements(np.zeros((8, 6)), target=Labels.same("x", 8)), "candidates: no target 'x'"),
    ):
        with pytest.raises(ec.InputError, match=message):
            ec.select_poses(arm(), given, 5)
    two = replace(arm(), targets={"a": Frame(), "b": Frame()})
    with pytest.raises(ec.InputError, match="candidates: expected each pose to name one of the targets a, b"):
        ec.select_poses(two, candidates(8), 5)


def test_the_wider_the_choice_the_better():
    q = candidates(500)
    parts = concatenate([Measurements(q), Measurements(candidates(500, 7))])
    narrow, wide = (ec.select_poses(arm(), offered, 20).observability.O1 for offered in (q[:40], parts))
    assert wide > 1.05 * narrow
