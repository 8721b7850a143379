"""Rotation matrices: the few maps that the chain needs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def skew(vectors: Array) -> Array:
    """Cross-product matrices (n, 3, 3) of vectors (n, 3): they turn b into a x b."""
    matrices = np.zeros((*vectors.shape, 3))
    x, y, z = np.moveaxis(vectors, -1, 0)
    matrices[..., 0, 1], matrices[..., 0, 2], matrices[..., 1, 2] = -z, y, -x
    matrices[..., 1, 0], matrices[..., 2, 0], matrices[..., 2, 1] = z, -y, x
    return matrices


def rotation_about(axis: Sequence[float], angle: float) -> Array:
    """The rotation (3, 3) about a unit axis (3,) by an angle [rad], by Rodrigues' formula."""
    cross = skew(np.asarray(axis))
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)


def rotation_from_rpy(rpy: Sequence[float]) -> Array:
    """Rz(yaw) Ry(pitch) Rx(roll), (3, 3), of roll, pitch and yaw [rad]."""
    (sr, sp, sy), (cr, cp, cy) = (tuple(map(function, rpy)) for function in (math.sin, math.cos))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rpy_from_rotation(rotation: Array) -> tuple[float, float, float]:
    """Roll, pitch and yaw [rad] of a rotation (3, 3); at a pitch of 90 deg, where they are not unique, roll is 0."""
    pitch = math.atan2(-rotation[2, 0], math.hypot(rotation[0, 0], rotation[1, 0]))
    unique = math.hypot(rotation[2, 1], rotation[2, 2]) > 1e-15
    roll = math.atan2(rotation[2, 1], rotation[2, 2]) if unique else 0.0
    sine, cosine = math.sin(roll), math.cos(roll)  # with roll taken back, yaw stands in entries that never vanish
    yaw = math.atan2(sine * rotation[0, 2] - cosine * rotation[0, 1], cosine * rotation[1, 1] - sine * rotation[1, 2])
    return roll, pitch, yaw


def rotations_from_z(axes: Array) -> Array:
    """Rotations (n, 3, 3) that take z onto each unit axis (n, 3): the shortest, and the identity for z itself."""
    flipped = axes[:, 2] < -0.5  # the shortest rotation from z is singular at -z: start from a half turn about x there
    turn = np.where(flipped[:, None, None], np.diag([1.0, -1.0, -1.0]), np.eye(3))
    x, y, z = np.einsum("nji,nj->in", turn, axes)
    cross = skew(np.stack([-y, x, np.zeros_like(z)], axis=1))
    shortest = np.eye(3) + cross + cross @ cross / (1.0 + z)[:, None, None]
    return turn @ shortest


def rotation_vectors(rotations: Array) -> Array:
    """Rotation vectors (3, n) [rad] of rotations (3, 3, n), the logarithm map; exact from 0 up to pi.

    By way of the quaternion's largest component (Shepperd, "Quaternion from rotation matrix", 1978).
    """
    m = rotations
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    squares = np.stack([1.0 + trace, *(1.0 - trace + 2.0 * m[i, i] for i in range(3))])
    w, x, y, z = (
        np.stack([squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]),
        np.stack([m[2, 1] - m[1, 2], squares[1], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0]]),
        np.stack([m[0, 2] - m[2, 0], m[1, 0] + m[0, 1], squares[2], m[2, 1] + m[1, 2]]),
        np.stack([m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], squares[3]]),
    )
    quaternion = np.choose(np.argmax(squares, axis=0), [w, x, y, z])
    quaternion = quaternion * np.where(quaternion[0] < 0.0, -1.0, 1.0) / np.linalg.norm(quaternion, axis=0)
    sine = np.linalg.norm(quaternion[1:], axis=0)
    angle = 2.0 * np.arctan2(sine, quaternion[0])
    return quaternion[1:] * np.divide(angle, sine, out=np.full_like(angle, 2.0), where=sine > 0.0)
