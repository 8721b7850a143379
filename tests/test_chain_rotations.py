"""Rotation matrices, vectors and angles: there and back, near zero, near a half turn and at gimbal lock."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from elastocal.chain import cross, rotation_about, rotation_from_rpy, rotation_vectors, rpy_from_rotation, skew
from elastocal.chain.rotations import rotations_from_z

ROUNDING = 4e-15
unit_vectors = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 3)
    .map(np.array)
    .filter(lambda v: np.linalg.norm(v) > 0.1)
    .map(lambda v: v / np.linalg.norm(v))
)
angles = st.floats(-np.pi, np.pi)
tiny = st.floats(0.0, 16.0).map(lambda exponent: 10.0**-exponent)


def for_all(*strategies: st.SearchStrategy) -> Callable[[Callable], Callable]:
    """The same examples in every run, however slow the machine."""
    return lambda test: settings(deadline=None, derandomize=True, database=None)(given(*strategies)(test))


@for_all(unit_vectors, angles)
def test_a_rotation_is_the_one_that_scipy_means(axis: np.ndarray, angle: float) -> None:
    np.testing.assert_allclose(
        rotation_about(axis, angle), Rotation.from_rotvec(axis * angle).as_matrix(), rtol=0, atol=ROUNDING
    )


@for_all(angles, angles, angles)
def test_roll_pitch_yaw_turn_about_fixed_axes(roll: float, pitch: float, yaw: float) -> None:
    expected = Rotation.from_euler("xyz", (roll, pitch, yaw)).as_matrix()
    np.testing.assert_allclose(rotation_from_rpy((roll, pitch, yaw)), expected, rtol=0, atol=ROUNDING)


@for_all(unit_vectors, st.floats(0.0, np.pi - 1e-6))
def test_a_rotation_vector_comes_back(axis: np.ndarray, angle: float) -> None:
    found = rotation_vectors(rotation_about(axis, angle)[:, :, None])[:, 0]
    np.testing.assert_allclose(found, axis * angle, rtol=0, atol=ROUNDING)


@for_all(unit_vectors, tiny)
def test_a_small_rotation_vector_comes_back_in_all_its_digits(axis: np.ndarray, angle: float) -> None:
    found = rotation_vectors(rotation_about(axis, angle)[:, :, None])[:, 0]
    np.testing.assert_allclose(found, axis * angle, rtol=0, atol=1e-15 + 1e-15 * angle)


@for_all(unit_vectors, tiny, st.sampled_from([-1.0, 1.0]))
def test_a_rotation_near_a_half_turn_comes_back(axis: np.ndarray, short: float, side: float) -> None:
    rotation = rotation_about(axis, np.pi + side * short)
    vector = rotation_vectors(rotation[:, :, None])[:, 0]
    assert np.linalg.norm(vector) <= np.pi + ROUNDING
    np.testing.assert_allclose(Rotation.from_rotvec(vector).as_matrix(), rotation, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("axis", np.eye(3))
def test_a_half_turn_about_a_main_axis_is_pi_along_it(axis: np.ndarray) -> None:
    half_turn = 2.0 * np.outer(axis, axis) - np.eye(3)
    np.testing.assert_allclose(np.abs(rotation_vectors(half_turn[:, :, None])[:, 0]), np.pi * axis, rtol=0, atol=0)


def test_no_rotation_is_a_vector_of_zeros() -> None:
    assert not rotation_vectors(np.eye(3)[:, :, None]).any()


def test_many_rotations_become_vectors_as_one_does() -> None:
    rotations = Rotation.random(50, rng=np.random.default_rng(1)).as_matrix().transpose(1, 2, 0)
    together = rotation_vectors(rotations)
    for i in range(50):
        np.testing.assert_array_equal(together[:, i], rotation_vectors(rotations[:, :, i : i + 1])[:, 0])


@for_all(angles, st.floats(-1.5, 1.5), angles)
def test_roll_pitch_yaw_come_back(roll: float, pitch: float, yaw: float) -> None:
    rotation = rotation_from_rpy((roll, pitch, yaw))
    np.testing.assert_allclose(rotation_from_rpy(rpy_from_rotation(rotation)), rotation, rtol=0, atol=1e-14)


@for_all(angles, st.sampled_from([-0.5 * np.pi, 0.5 * np.pi]), angles)
def test_a_rotation_at_gimbal_lock_comes_back_with_no_roll(roll: float, pitch: float, yaw: float) -> None:
    rotation = rotation_from_rpy((roll, pitch, yaw))
    found = rpy_from_rotation(rotation)
    assert found[0] == 0.0
    assert found[1] == pytest.approx(pitch, abs=1e-15)
    np.testing.assert_allclose(rotation_from_rpy(found), rotation, rtol=0, atol=ROUNDING)


def test_a_rotation_next_to_gimbal_lock_comes_back() -> None:
    rng = np.random.default_rng(2)
    for exponent in range(4, 16):
        for _ in range(20):
            pitch = 0.5 * np.pi - 10.0**-exponent * rng.uniform(1.0, 10.0)
            rpy = rng.uniform(-3.0, 3.0), rng.choice([-1.0, 1.0]) * pitch, rng.uniform(-3.0, 3.0)
            rotation = Rotation.from_euler("xyz", rpy).as_matrix()
            np.testing.assert_allclose(rotation_from_rpy(rpy_from_rotation(rotation)), rotation, rtol=0, atol=1e-13)


@for_all(unit_vectors)
def test_the_rotation_from_z_takes_z_onto_the_axis(axis: np.ndarray) -> None:
    found = rotations_from_z(axis[None])[0]
    np.testing.assert_allclose(found[:, 2], axis, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(found @ found.T, np.eye(3), rtol=0, atol=ROUNDING)
    assert np.linalg.det(found) > 0.0


@pytest.mark.parametrize("z", [1.0, -1.0])
@pytest.mark.parametrize("tilt", [0.0, 1e-300, 1e-12, 1e-8])
def test_the_rotation_from_z_is_one_near_both_poles(z: float, tilt: float) -> None:
    axis = np.array([tilt, -tilt, z]) / np.sqrt(1.0 + 2.0 * tilt * tilt)
    found = rotations_from_z(axis[None])[0]
    np.testing.assert_allclose(found[:, 2], axis, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(found @ found.T, np.eye(3), rtol=0, atol=ROUNDING)


@for_all(unit_vectors, unit_vectors)
def test_skew_and_cross_are_the_cross_product(left: np.ndarray, right: np.ndarray) -> None:
    np.testing.assert_allclose(skew(left) @ right, np.cross(left, right), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(cross(left[:, None], right[:, None])[:, 0], np.cross(left, right), rtol=0, atol=ROUNDING)
