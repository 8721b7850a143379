"""What must hold for the predictions of every robot, rigid or not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastocal.prediction import predict
from elastocal.robot import Compliance, Frame, Payload, Robot
from support.robots import arm, placed, random_dh_robot
from support.urdf import compliant, equipped, posed

SAME = 1e-12
SEEDS = range(4)
OTHERS = ("2.alpha", "3.a", "tool.rz")


def robot_of(seed: int, turn: float = 1e-4) -> Robot:
    rng = np.random.default_rng(seed)
    convention = ("modified-dh", "standard-dh")[seed % 2]
    return compliant(equipped(random_dh_robot(rng, convention, prismatic=0.3), rng), OTHERS, turn, turn / 10.0)


def poses(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(100 + seed)
    return rng.uniform(-1.5, 1.5, (8, 6)), rng.normal(size=(8, 6)) * 40.0


@pytest.mark.parametrize("seed", SEEDS)
def test_moving_the_instrument_moves_all_predictions_rigidly(seed: int) -> None:
    robot, (q, wrench) = robot_of(seed), poses(seed)
    rng = np.random.default_rng(seed)
    turn, shift = Rotation.random(rng=rng).as_matrix(), rng.uniform(-5.0, 5.0, 3)
    moved = replace(robot, base=robot.base.at(turn @ robot.base.translation + shift, turn @ robot.base.rotation))
    position, rotation = predict(robot, q, target="far", load="heavy", wrench=wrench)
    position_after, rotation_after = predict(moved, q, target="far", load="heavy", wrench=wrench)
    np.testing.assert_allclose(position_after, position @ turn.T + shift, rtol=0, atol=SAME)
    np.testing.assert_allclose(rotation_after, turn @ rotation, rtol=0, atol=SAME)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_station_is_a_base_with_another_name(seed: int) -> None:
    robot, (q, wrench) = robot_of(seed), poses(seed)
    named = predict(robot, q, station="north", wrench=wrench)
    for ours, theirs in zip(
        named, predict(replace(robot, base=robot.stations["north"]), q, wrench=wrench), strict=True
    ):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("seed", SEEDS)
def test_gravity_is_given_in_the_base_frame_however_the_instrument_stands(seed: int) -> None:
    robot, (q, _) = replace(robot_of(seed), base=Frame()), poses(seed)
    turn = Rotation.from_euler("xyz", (0.4, -0.2, 0.7)).as_matrix()
    tilted = replace(robot, base=Frame().at(np.zeros(3), turn))
    np.testing.assert_allclose(predict(tilted, q)[0], predict(robot, q)[0] @ turn.T, rtol=0, atol=SAME)
    hung = replace(robot, gravity=tuple((turn.T @ robot.gravity).tolist()))
    assert np.abs(predict(hung, q)[0] - predict(robot, q)[0]).max() > 1e-4


@pytest.mark.parametrize("seed", SEEDS)
def test_a_target_is_fixed_to_the_tool(seed: int) -> None:
    robot, (q, wrench) = robot_of(seed), poses(seed)
    position, rotation = predict(robot, q, wrench=wrench)
    target = robot.targets["far"]
    at, turned = predict(robot, q, target="far", wrench=wrench)
    np.testing.assert_allclose(at, position + rotation @ target.translation, rtol=0, atol=SAME)
    np.testing.assert_allclose(turned, rotation @ target.rotation, rtol=0, atol=SAME)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_payload_adds_to_the_mass_of_the_tool(seed: int) -> None:
    robot, (q, _) = robot_of(seed), poses(seed)
    tool, load = robot.tool_load, robot.loads["heavy"]
    mass = tool.mass + load.mass
    com = (tool.mass * np.array(tool.com) + load.mass * np.array(load.com)) / mass
    merged = replace(robot, tool_load=Payload(mass, tuple(com.tolist())))
    np.testing.assert_allclose(predict(robot, q, load="heavy")[0], predict(merged, q)[0], rtol=0, atol=SAME)


@pytest.mark.parametrize("seed", SEEDS)
def test_identifying_the_tool_moves_no_mass(seed: int) -> None:
    robot, (q, _) = robot_of(seed), poses(seed)
    robot = replace(robot, elastic={name: c for name, c in robot.elastic.items() if not name.startswith("tool")})
    flange = replace(robot, tool=Frame())
    position, rotation = predict(flange, q, load="heavy")
    at, _ = predict(robot, q, load="heavy")
    np.testing.assert_allclose(at, position + rotation @ robot.tool.translation, rtol=0, atol=SAME)


@pytest.mark.parametrize("seed", SEEDS)
def test_an_external_force_equal_to_the_weight_of_a_payload_bends_as_it_does(seed: int) -> None:
    robot, (q, _) = robot_of(seed), poses(seed)
    robot = replace(robot, elastic={name: c for name, c in robot.elastic.items() if not name.startswith("tool")})
    position, rotation = predict(robot, q, load="heavy")
    load = robot.loads["heavy"]
    weight = load.mass * robot.base.rotation @ robot.gravity
    in_flange = robot.tool.rotation.T @ (np.array(load.com) - robot.tool.translation)
    force = np.einsum("nji,j->ni", rotation, weight)
    wrench = np.concatenate([force, np.cross(in_flange, force)], axis=1)
    ours = predict(robot, q, wrench=wrench)
    np.testing.assert_allclose(ours[0], position, rtol=0, atol=SAME)
    np.testing.assert_allclose(ours[1], rotation, rtol=0, atol=SAME)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_rigid_robot_is_where_plain_matrices_put_it_whatever_hangs_on_it(seed: int) -> None:
    robot, (q, wrench) = replace(robot_of(seed), elastic={}), poses(seed)
    position, rotation = predict(robot, q, station="north", target="near", load="heavy", wrench=wrench)
    expected = [posed(robot, p, {}, "north", "near").frames[-1] for p in q]
    np.testing.assert_allclose(position, [frame[:3, 3] for frame in expected], rtol=0, atol=1e-13)
    np.testing.assert_allclose(rotation, [frame[:3, :3] for frame in expected], rtol=0, atol=1e-13)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_controller_that_counts_the_other_way_is_a_joint_with_the_other_sign(seed: int) -> None:
    robot, (q, wrench) = replace(robot_of(seed), coupling=None), poses(seed)
    flipped = replace(robot, rows=tuple(replace(row, sign=-row.sign) for row in robot.rows))
    np.testing.assert_array_equal(predict(robot, q, wrench=wrench)[0], predict(flipped, -q, wrench=wrench)[0])


def test_a_coupling_turns_the_controllers_positions_into_the_models() -> None:
    robot, (q, _) = robot_of(0), poses(0)
    own = predict(replace(robot, coupling=None), q @ np.array(robot.coupling).T)
    np.testing.assert_allclose(predict(robot, q)[0], own[0], rtol=0, atol=1e-13)


def test_fewer_controller_positions_than_joints_drive_a_parallelogram() -> None:
    robot = replace(arm(), rows=arm().rows[:3], coupling=((1.0, 0.0), (0.0, 1.0), (0.0, -1.0)))
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (5, 2))
    own = predict(replace(robot, coupling=None), np.stack([q[:, 0], q[:, 1], -q[:, 1]], axis=1))
    np.testing.assert_allclose(predict(robot, q)[1], own[1], rtol=0, atol=1e-14)


def test_small_deflections_are_proportional_to_compliance() -> None:
    robot = placed(arm(elastic=True), np.random.default_rng(2))
    q, _ = poses(0)
    rigid = predict(replace(robot, elastic={}), q)[0]

    def bent(scale: float) -> np.ndarray:
        springs = {n: Compliance("linear", (scale * c.coefficients[0],)) for n, c in robot.elastic.items()}
        return (predict(replace(robot, elastic=springs), q)[0] - rigid) / scale

    np.testing.assert_allclose(bent(1e-5), bent(2e-5), rtol=0, atol=1e-4 * np.abs(bent(1e-5)).max())


def test_a_name_that_the_robot_does_not_have_is_refused() -> None:
    for names in ({"station": "south"}, {"target": "missing"}, {"load": "huge"}):
        with pytest.raises(KeyError):
            predict(robot_of(1), np.zeros((1, 6)), **names)
