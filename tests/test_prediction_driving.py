"""How the target follows the joints, against central differences: elastic, with joint maps, coupled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.chain import rotation_vectors
from elastocal.prediction.driving import Driver, map_slope
from elastocal.robot import Compliance, JointMap, Payload, Robot
from support.differences import central_difference
from support.robots import arm, random_dh_robot

STEP = 1e-4


def soft(robot: Robot) -> Robot:
    """Compliant joints of all laws and a compliant link, joint maps, coupled joints, a payload."""
    laws = {
        "1.theta": Compliance("linear", (2e-6,)),
        "2.theta": Compliance("hinge", (3e-6, 1e-6), 40.0),
        "3.theta": Compliance("cubic", (4e-6, -1e-12)),
        "5.theta": Compliance("step", (2e-5, 1e-5), 3.0),
        "2.alpha": Compliance("linear", (1e-6,)),
    }
    coupling = np.eye(6)
    coupling[2, 1], coupling[5, 4] = 1.0, -0.5
    return replace(
        robot,
        elastic=laws,
        transmission={"2.theta": JointMap((1e-4, 0.0, 3e-4), (0.0, 2e-4, 0.0)), "6.theta": JointMap((1e-3,), (5e-4,))},
        loads={"heavy": Payload(15.0, (0.05, 0.0, 0.1))},
        coupling=tuple(map(tuple, coupling.tolist())),
    )


def moved(driver: Driver, q: np.ndarray, joint: int, wrench: np.ndarray | None, sides: np.ndarray) -> np.ndarray:
    """Displacement and rotation vector of the target per unit of a joint, by differences."""
    here = driver.at(q, wrench, sides).rotation

    def pose(delta: float) -> np.ndarray:
        there = driver.at(q + delta * np.eye(len(q))[:, joint, None], wrench, sides, derivatives=False)
        turn = rotation_vectors(np.einsum("ijn,kjn->ikn", there.rotation, here))
        return np.concatenate([there.position, turn])

    return central_difference(pose, STEP)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("pulled", [False, True])
def test_the_driving_jacobian_agrees_with_central_differences(seed: int, pulled: bool):
    rng = np.random.default_rng(seed)
    robot = soft(arm() if seed == 0 else random_dh_robot(rng, "modified-dh"))
    driver = Driver.of(robot, load="heavy")
    q = rng.uniform(-1.0, 1.0, (6, 40))
    wrench = rng.normal(size=(6, 40)) * 50.0 if pulled else None
    sides = driver.undeflected_loads(q, wrench)
    kink = (
        np.abs(
            np.abs(
                sides[driver.assembly.mechanism.chain.index["2.theta"] == np.array(driver.assembly.mechanism.elastic)][
                    0
                ]
            )
            - 40.0
        )
        > 2.0
    )  # a hinge has no derivative at its torque
    jacobian = driver.at(q, wrench, sides).jacobian
    for joint in range(6):
        expected = moved(driver, q, joint, wrench, sides)
        np.testing.assert_allclose(jacobian[:, joint, kink], expected[:, kink], atol=2e-6)


def test_driving_predicts_what_predict_does():
    robot = soft(arm())
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (30, 6))
    positions, rotations = ec.predict(robot, q, load="heavy")
    driven = Driver.of(robot, load="heavy").at(q.T)
    np.testing.assert_array_equal(driven.position.T, positions)
    np.testing.assert_array_equal(np.moveaxis(driven.rotation, -1, 0), rotations)


def test_sliding_joints_are_driven_along_their_axes():
    robot = random_dh_robot(np.random.default_rng(3), "standard-dh", joints=5, prismatic=0.6)
    driver = Driver.of(robot)
    q = np.random.default_rng(1).uniform(-0.5, 0.5, (5, 20))
    sides = driver.undeflected_loads(q)
    for joint in range(5):
        np.testing.assert_allclose(driver.at(q).jacobian[:, joint], moved(driver, q, joint, None, sides), atol=1e-8)


def test_the_slope_of_a_joint_map_is_its_derivative():
    error = JointMap((1.0, -0.5, 0.2), (0.3, 0.7, -0.1))
    q = np.linspace(-3.0, 3.0, 25)
    np.testing.assert_allclose(map_slope(error, q), central_difference(lambda d: error.at(q + d), 1e-3), atol=1e-9)
