"""A chain cut at its joints: what is constant between them, as homogeneous matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from elastocal.chain import Array, Element, Vector, rotation_about
from elastocal.chain.rotations import rotations_from_z
from elastocal.robot import Frame, Robot, Row

PARALLEL = 1e-15
"""Axes whose directions agree to this are the same."""


@dataclass(frozen=True)
class Segment:
    """What one row does: a constant transform, its joint, and another constant transform.

    Attributes:
        row: it.
        before: (4, 4) up to the joint, with all that is about or along the joint's own axis.
        axis: of the joint in the frame after `before`; the controller counts about or along it.
        after: (4, 4) from the joint to the end of the row.
    """

    row: Row
    before: Array
    axis: Vector
    after: Array


class AlignedJoint(NamedTuple):
    """A joint about or along z of a frame, and that frame in the one of the joint before it, (4, 4)."""

    row: Row
    before: Array


def homogeneous(rotation: Array | None = None, translation: Array | Sequence[float] | None = None) -> Array:
    """A transform (4, 4) of a rotation (3, 3) and a translation (3,)."""
    whole = np.eye(4)
    if rotation is not None:
        whole[:3, :3] = rotation
    if translation is not None:
        whole[:3, 3] = translation
    return whole


def frame_of(transform: Array) -> Frame:
    """A known frame at a transform (4, 4)."""
    return Frame(known=True).at(transform[:3, 3], transform[:3, :3])


def segments(robot: Robot) -> tuple[Segment, ...]:
    """The rows of a robot, each cut at its joint."""
    return tuple(map(_segment, robot.rows, robot.row_elements))


def _segment(row: Row, elements: Sequence[Element]) -> Segment:
    before, after = np.eye(4), np.eye(4)
    axis: Vector = (0.0, 0.0, 1.0)
    passed, commutes = False, False
    for element in elements:
        transform = _matrix(element)
        if row.joint and element.name == row.joint_element:
            x, y, z = element.axis
            axis, passed, commutes = (row.sign * x, row.sign * y, row.sign * z), True, True
            before = before @ transform
        elif not passed or (commutes := commutes and _parallel(element.axis, axis)):
            before = before @ transform
        else:
            after = after @ transform
    return Segment(row, before, axis, after)


def _matrix(element: Element) -> Array:
    if element.rotation:
        return homogeneous(rotation_about(element.axis, element.value))
    return homogeneous(translation=np.array(element.axis) * element.value)


def _parallel(one: Vector, other: Vector) -> bool:
    return float(np.linalg.norm(np.cross(one, other))) < PARALLEL


def aligned_joints(robot: Robot) -> tuple[tuple[AlignedJoint, ...], Array]:
    """The joints in frames whose z is their axis, as the controller counts, and the flange in the last one's (4, 4).

    Fixed rows are merged. The robot is its first frame, and a joint's frame lies where its row puts it.
    """
    joints, reached = [], np.eye(4)
    for segment in segments(robot):
        reached = reached @ segment.before
        if segment.row.joint:
            turn = homogeneous(rotations_from_z(np.array([segment.axis]))[0])
            joints.append(AlignedJoint(segment.row, reached @ turn))
            reached = turn.T
        reached = reached @ segment.after
    return tuple(joints), reached
