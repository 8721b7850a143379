"""Which poses surroundings reject, judged by dense points along the links; and the order of a plan."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, permutations, product

import numpy as np
import pytest

import elastocal as ec
from elastocal.design import Surroundings, draw_candidates, draw_workspace, kept_candidates
from elastocal.design.links import distance_to_box
from elastocal.design.ordering import short_order, travel
from elastocal.design.surroundings import scene
from elastocal.measurements import Labels, Measurements
from elastocal.robot import Frame, Robot, assemble
from elastocal.simulation import Region
from support.robots import arm

BOXES = (((0.3, 0.9), (-0.4, 0.2), (0.1, 0.7)), ((-1.5, -0.5), (-2.0, 2.0), (0.5, 3.0)))


def home(**changes: object) -> Robot:
    """The arm with its base at the origin and a target aside of the flange."""
    return replace(arm(), base=Frame((0.0, 0.0, 0.0), known=True), tool=Frame((0.1, -0.05, 0.2)), **changes)


def link_points(robot: Robot, q: np.ndarray, each: int = 60) -> np.ndarray:
    """Points (poses, points, 3) along the moving links, by predicting robots that are cut off after each row."""
    joints = []
    for rows in range(1, len(robot.rows) + 1):
        cut = replace(robot, rows=robot.rows[:rows], tool=Frame(), elastic={})
        joints.append(ec.predict(cut, q[:, :rows])[0])
    joints.append(ec.predict(robot, q)[0])
    shares = np.linspace(0.0, 1.0, each)[:, None, None]
    pieces = [a + shares * (b - a) for a, b in pairwise(joints)]
    return np.concatenate(pieces).transpose(1, 0, 2)


def test_the_distance_of_a_segment_from_a_box_is_that_of_its_nearest_point():
    rng = np.random.default_rng(0)
    starts, ends = rng.uniform(-2.0, 2.0, (2, 3, 400))
    ends[0, :40] = starts[0, :40]  # some along a face
    ends[:, :10] = starts[:, :10]  # some are points
    low, high = np.array([-0.5, -0.2, 0.1]), np.array([0.4, 0.9, 0.6])
    shares = np.linspace(0.0, 1.0, 4001)[:, None, None]
    points = starts + shares * (ends - starts)
    dense = np.linalg.norm(points - np.clip(points, low[:, None], high[:, None]), axis=1).min(axis=0)
    found = distance_to_box(starts, ends, low, high)
    assert (found <= dense + 1e-12).all() and found == pytest.approx(dense, abs=1e-5)
    assert (found == 0.0).sum() > 10


@pytest.mark.parametrize("radius", [0.0, 0.12])
def test_no_link_enters_a_box_or_the_floor(radius: float):
    robot, q = home(), ec.random_poses(arm(), 1500, 1)
    around = Surroundings(Region(floor=0.05), keep_out=BOXES, link_radius=radius)
    rejected = scene(robot, around).rejected(q)
    points = link_points(robot, q)
    for name, box in zip(("keep-out 1", "keep-out 2"), BOXES, strict=True):
        low, high = np.array(box).T
        near = np.linalg.norm(points - np.clip(points, low, high), axis=2).min(axis=1)
        clear = np.abs(near - radius) > 0.01  # the points are 1 cm apart
        assert np.array_equal(rejected[name][clear], (near <= radius)[clear])
        assert 20 < rejected[name].sum() < 1400
    lowest = points[:, :, 2].min(axis=1) - radius
    assert np.array_equal(rejected["floor under the links"], lowest <= 0.05)


def test_the_pedestal_may_stand_on_the_floor_and_one_pose_is_judged_as_many_are():
    at = scene(home(), Surroundings(Region(floor=0.3), keep_out=BOXES, link_radius=0.1))
    upright = np.array([[0.0, -np.pi / 2.0, 0.0, 0.0, 0.0, 0.0]])
    assert not at.rejected(upright)["floor under the links"].any()
    q = ec.random_poses(arm(), 40, 3)
    together = at.rejected(q)
    for i in range(40):
        alone = at.rejected(q[i : i + 1])
        assert {name: misses[i] for name, misses in together.items()} == {n: m[0] for n, m in alone.items()}


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)])
@pytest.mark.parametrize("known", [True, False])
def test_the_instrument_sees_the_target_that_faces_it(known: bool, axis: tuple[float, float, float]):
    """The base in the robot file and the instrument's origin in the base frame say the same."""
    base = Frame((2.5, -1.0, 0.4), (0.1, 0.2, 2.0), known=True)
    instrument = -base.rotation.T @ base.translation
    region = Region(range=(2.0, 3.2), cone=0.3)
    around = Surroundings(region, facing=1.0, axis=axis, aim=(0.5, 0.0, 0.5))
    robot = home()
    if known:
        robot = replace(robot, base=base)
    else:
        around = replace(around, instrument=tuple(instrument.tolist()))
    q = ec.random_poses(arm(), 3000, 2)
    rejected = scene(robot, around).rejected(q)
    position, rotation = ec.predict(home(), q)
    towards = instrument - position
    distance = np.linalg.norm(towards, axis=1)
    facing = np.einsum("ni,nij,j->n", towards, rotation, axis) / distance
    middle = np.array([0.5, 0.0, 0.5]) - instrument
    along = -towards @ middle / np.linalg.norm(middle) / distance
    expected = {
        "range": (distance < 2.0) | (distance > 3.2),
        "cone": along < np.cos(0.3),
        "facing": facing < np.cos(1.0),
    }
    for name, misses in expected.items():
        assert np.array_equal(rejected[name], misses), name
        assert 100 < misses.sum() < 2900


def test_candidates_are_allowed_and_shared_out():
    targets = {"a": Frame((0.1, 0.0, 0.0), known=True), "b": Frame((0.0, 0.2, 0.1), known=True)}
    robot = home(targets=targets)
    around = Surroundings(Region(floor=0.2), keep_out=BOXES[:1], link_radius=0.05)
    found = draw_candidates(robot, 301, 10, around, targets=["a", "b"])
    assert {c.target: len(c.rows) for c in found.poses.combinations} == {"a": 151, "b": 150}
    for part in found.poses.combinations:
        assert ec.predict(robot, found.poses.q[part.rows], target=part.target)[0][:, 2].min() > 0.2
    again = kept_candidates(robot, found.poses, 301, around)
    assert np.array_equal(again.poses.q, found.poses.q)
    assert np.array_equal(draw_candidates(robot, 301, 10, around, targets=["a", "b"]).poses.q, found.poses.q)


def test_what_rejects_all_candidates_is_named():
    with pytest.raises(ec.InputError, match=r"found 0 candidates, expected at least 5: of \d+ drawn .* floor rejects"):
        draw_candidates(home(), 100, 5, Surroundings(Region(floor=9.0)))
    q = ec.random_poses(arm(), 50, 1)
    everywhere = ((-5.0, 5.0),) * 3
    with pytest.raises(ec.InputError, match=r"expected at least 5: of 50 candidates given, keep-out 1 rejects 50; wid"):
        kept_candidates(home(), Measurements(q), 5, Surroundings(keep_out=(everywhere,)))
    with pytest.raises(ec.InputError, match=r"cone, facing: expected to know where the instrument stands: give its pl"):
        scene(arm(), Surroundings(Region(cone=0.3), facing=1.0))


def test_all_faults_of_surroundings_are_told_at_once():
    with pytest.raises(ec.InputError) as caught:
        Surroundings(
            keep_out=(((1.0, 0.0), (0.0, 1.0), (2.0, 1.0)),), facing=4.0, link_radius=-1.0, aim=(0.0, 0.0, 0.0)
        )
    assert caught.value.faults == (
        "keep-out 1: expected the lowest x and then the highest, found 1 m and 0 m",
        "keep-out 1: expected the lowest z and then the highest, found 2 m and 1 m",
        "facing: expected an angle between 0 and 180 deg, found 229.183 deg",
        "link radius: expected 0 or a positive length, found -1 m",
        "aim is of the middle of a cone, of which there is none: give a cone too",
    )


def test_a_workspace_is_where_it_is_named():
    box = ((0.4, 1.2), (-0.5, 0.5), (0.3, 1.0))
    around = Surroundings(Region(floor=0.1, cone=0.01), instrument=(3.0, 0.0, 0.0))
    poses = draw_workspace(home(), box, around, Measurements(np.zeros((1, 6))))
    position = ec.predict(home(), poses.q)[0]
    low, high = np.array(box).T
    assert ((low <= position) & (position <= high)).all() and len(poses) == 1000
    with pytest.raises(ec.InputError, match=r"found 0 candidates, expected at least 1: .* the workspace rejects"):
        draw_workspace(home(), ((8.0, 9.0),) * 3, around, Measurements(np.zeros((1, 6))))


@pytest.mark.parametrize("start", [None, np.full(3, 0.2)])
@pytest.mark.parametrize("seed", range(5))
def test_the_order_is_the_shortest_of_few_and_never_longer(seed: int, start: np.ndarray | None):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2.0, 2.0, (7, 3))
    order = short_order(Measurements(q), start)
    assert sorted(order.tolist()) == list(range(7))
    shortest = min(travel(q[list(way)], start) for way in permutations(range(7)))
    assert travel(q[order], start) <= 1.03 * shortest
    many = rng.uniform(-2.0, 2.0, (60, 6))
    from_there = None if start is None else np.zeros(6)
    ordered = many[short_order(Measurements(many), from_there)]
    assert sorted(map(tuple, ordered)) == sorted(map(tuple, many))
    assert travel(ordered, from_there) < 0.75 * travel(many, from_there)


def test_one_pose_is_in_order():
    assert short_order(Measurements(np.zeros((1, 6)))).tolist() == [0]


def test_payloads_are_changed_as_seldom_as_may_be():
    rng = np.random.default_rng(3)
    names = [(load, target) for load, target in product(("light", "heavy"), ("a", "b")) for _ in range(8)]
    shuffled = [names[i] for i in rng.permutation(len(names))]
    loads, targets = (Labels.of(column) for column in zip(*shuffled, strict=True))
    data = Measurements(rng.uniform(-2.0, 2.0, (32, 6)), load=loads, target=targets)
    found = data.take(short_order(data))
    assert (np.diff(found.target.codes) != 0).sum() == 1
    assert (np.diff(found.load.codes) != 0).sum() <= 3


def test_links_of_every_convention_meet_at_the_joints():
    """The target of the posture is what is predicted, with payload and tool."""
    from elastocal.design.links import posture

    robot, q = home(), ec.random_poses(arm(), 5, 4)
    at = posture(assemble(robot), q)
    position, rotation = ec.predict(robot, q)
    assert pytest.approx(position, abs=1e-12) == at.target.T
    assert at.axes.transpose(2, 0, 1) == pytest.approx(rotation, abs=1e-12)
