"""Predictions do not depend on the order of poses, nor on where one block of them ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.errors import EquilibriumError
from elastocal.measurements import Labels, Measurements
from elastocal.prediction import Model, predict
from elastocal.prediction.model import BLOCK
from elastocal.robot import Compliance, Robot
from support.robots import arm, placed
from support.urdf import equipped

SAME = 1e-12


def soft_arm() -> Robot:
    robot = placed(arm(elastic=True), np.random.default_rng(1))
    return replace(robot, elastic={name: Compliance("linear", (1e-4,)) for name in robot.elastic})


def poses(n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(2)
    return rng.uniform(-1.5, 1.5, (n, 6)), rng.normal(size=(n, 6)) * 30.0


def test_predictions_do_not_depend_on_the_order_of_poses() -> None:
    robot, (q, wrench) = soft_arm(), poses(BLOCK + 500)
    order = np.random.default_rng(3).permutation(len(q))
    in_order, shuffled = predict(robot, q, wrench=wrench), predict(robot, q[order], wrench=wrench[order])
    for number in range(2):
        np.testing.assert_allclose(in_order[number][order], shuffled[number], rtol=0, atol=SAME)


def test_predictions_do_not_depend_on_the_ends_of_blocks() -> None:
    robot, (q, wrench) = soft_arm(), poses(2 * BLOCK + 3)
    pieces = (slice(0, 7), slice(7, BLOCK + 1), slice(BLOCK + 1, None))
    whole = predict(robot, q, wrench=wrench)
    for number in range(2):
        found = np.concatenate([predict(robot, q[piece], wrench=wrench[piece])[number] for piece in pieces])
        np.testing.assert_allclose(whole[number], found, rtol=0, atol=SAME)


def test_one_pose_may_be_given_without_its_row() -> None:
    robot = soft_arm()
    np.testing.assert_array_equal(predict(robot, np.zeros(6))[0], predict(robot, np.zeros((1, 6)))[0])


def test_no_poses_are_no_predictions() -> None:
    position, rotation = predict(soft_arm(), np.zeros((0, 6)))
    assert position.shape == (0, 3)
    assert rotation.shape == (0, 3, 3)


def test_parts_agree_with_predictions_row_by_row_whatever_rows_observe(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("elastocal.prediction.model.BLOCK", 100)
    rng = np.random.default_rng(4)
    robot = equipped(soft_arm(), rng)
    n = 2000
    q, wrench = poses(n)
    labels = {
        "station": rng.choice(np.array([None, "north"]), n).tolist(),
        "target": rng.choice(np.array([None, "near", "far"]), n, p=[0.8, 0.1, 0.1]).tolist(),
        "load": rng.choice(np.array([None, "heavy"]), n, p=[0.95, 0.05]).tolist(),
    }
    position, distance = np.zeros((n, 3)), np.zeros(n)
    position[rng.random(n) < 0.3] = np.nan
    distance[np.isfinite(position[:, 0]) & (rng.random(n) < 0.5)] = np.nan
    data = Measurements(
        q=q, position=position, distance=distance, wrench=wrench, **{k: Labels.of(v) for k, v in labels.items()}
    )
    expected = np.empty((n, 3))
    for key in set(zip(*labels.values(), strict=True)):
        rows = [i for i, row in enumerate(zip(*labels.values(), strict=True)) if row == key]
        names = dict(zip(labels, key, strict=True))
        expected[rows] = predict(robot, q[rows], wrench=wrench[rows], **names)[0]

    seen = {"position": np.zeros(n, dtype=bool), "distance": np.zeros(n, dtype=bool)}
    for part in Model(robot, (), data).parts(np.zeros(0), derivatives=False):
        right = expected[part.rows].T if part.kind == "position" else np.linalg.norm(expected[part.rows], axis=1)[None]
        np.testing.assert_allclose(-part.residual, right, rtol=0, atol=SAME)
        assert not seen[part.kind][part.rows].any()
        seen[part.kind][part.rows] = True
    np.testing.assert_array_equal(seen["position"], np.isfinite(position[:, 0]))
    np.testing.assert_array_equal(seen["distance"], np.isfinite(distance))


def test_a_pose_that_does_not_settle_is_named_by_its_number_in_all_the_poses() -> None:
    q, wrench = poses(BLOCK + 9)
    wrench[BLOCK + 5, :3] = 1e7
    with pytest.raises(EquilibriumError) as error:
        predict(soft_arm(), q, wrench=wrench)
    assert error.value.pose == BLOCK + 5


def test_a_row_that_does_not_settle_is_named_by_its_number_in_the_data() -> None:
    robot = equipped(soft_arm(), np.random.default_rng(4))
    q, wrench = poses(4)
    wrench[3, :3] = 1e7
    data = Measurements(q, position=np.zeros((4, 3)), wrench=wrench, target=Labels.of(["near", "near", "far", "far"]))
    with pytest.raises(EquilibriumError) as error:
        list(Model(robot, (), data).parts(np.zeros(0), derivatives=False))
    assert error.value.pose == 3
