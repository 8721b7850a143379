"""Any chain as a plain table of four Denavit-Hartenberg parameters a joint, standard or modified.

Between two joints about z, Rz(turn) Tz(slide) Tx(a) Rx(alpha) Rz(next turn) Tz(next slide) is any transform: a and
alpha are length and twist of the common normal of the two axes, and what is about z joins the joints.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from elastocal.chain import X_AXIS, Y_AXIS, Z_AXIS, Array, rotation_about
from elastocal.conversion.deviation import at_its_base, rigid
from elastocal.conversion.segments import AlignedJoint, aligned_joints, frame_of, homogeneous
from elastocal.identification import calibrate
from elastocal.measurements import Measurements
from elastocal.prediction import predict
from elastocal.robot import Robot, Row

LONGEST = 10.0
"""A common normal further away than this [m] along an axis is of no use in a table: the axes count as parallel."""

SAME_DIRECTION = 1e-12
"""Axes whose sine is below this are parallel."""


class Passage(NamedTuple):
    """From one joint's frame to the next: Rz(turn) Tz(slide) Tx(a) Rx(alpha) [Ry(beta)] Rz(next_turn) Tz(next_slide).

    `beta` is what no plain table holds; zero where the common normal is used.
    """

    turn: float
    slide: float
    a: float
    alpha: float
    next_turn: float
    next_slide: float
    beta: float = 0.0


NO_PASSAGE = Passage(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

NOTHING = 1e-9
"""A turn or a way below this [rad or m] is none."""


@dataclass(frozen=True)
class Table:
    """A plain Denavit-Hartenberg table as a robot.

    Attributes:
        robot: rigid, each row a joint without beta and b; `base` is from the robot's base to the table's first frame,
            `tool` from its last one to the tool.
        tilts: angles between neighbouring axes that it cannot hold, by the pair of rows [rad].
        distance: (poses,) of its tool's origin from that of the rigid robot [m].
    """

    robot: Robot
    tilts: Mapping[tuple[str, str], float]
    distance: Array


def dh_table(robot: Robot, convention: str, q: Array, longest: float = LONGEST) -> Table:
    """A robot's geometry as a plain table, exact where neighbouring axes are not nearly parallel.

    Where the common normal of two axes lies more than `longest` away, the axes keep their distance and their tilt about
    it, lose the tilt across it, and the whole table, base and tool are fitted to the rigid robot at poses q.

    Args:
        robot: with joints that are not coupled.
        convention: "standard-dh" or "modified-dh".
        q: (poses, joints) joint positions [rad or m].
        longest: way along an axis to a common normal [m] that is still taken.
    """
    joints, end = aligned_joints(robot)
    passages = [passage(transform, longest) for transform in (*(joint.before for joint in joints), end)]
    rows, base, rest = (_standard if convention == "standard-dh" else _modified)(joints, passages)
    tool = rest @ homogeneous(robot.tool.rotation, robot.tool.translation)
    table = replace(rigid(robot), convention=convention, rows=rows, base=frame_of(base), tool=frame_of(tool))
    names = [joint.row.name for joint in joints]
    tilts = {pair: p.beta for pair, p in zip(pairwise(names), passages[1:-1], strict=True) if p.beta}
    position, orientation = predict(at_its_base(rigid(robot)), q)
    if tilts:
        table = _fitted(table, Measurements(q, position, orientation))
    return Table(table, tilts, np.linalg.norm(predict(table, q)[0] - position, axis=1))


def passage(transform: Array, longest: float = LONGEST) -> Passage:
    """A transform (4, 4) from one joint's frame to the next, by the common normal of their axes, `longest` [m] away."""
    rotation, p = transform[:3, :3], transform[:3, 3]
    direction = rotation[:, 2]
    if math.hypot(direction[0], direction[1]) < SAME_DIRECTION:
        return _parallel(rotation, p, nearly=False)
    turn = _folded(math.atan2(direction[0], -direction[1]))
    x, y = np.array([math.cos(turn), math.sin(turn), 0.0]), np.array([-math.sin(turn), math.cos(turn), 0.0])
    sine = -float(direction @ y)
    next_slide = -float(p @ y) / sine
    slide = float(p[2] - next_slide * direction[2])
    if max(abs(slide), abs(next_slide)) > longest:
        return _parallel(rotation, p, nearly=True)
    alpha = math.atan2(sine, direction[2])
    return Passage(turn, slide, float(p @ x), alpha, _last_turn(rotation, turn, alpha), next_slide)


def _parallel(rotation: Array, p: Array, nearly: bool) -> Passage:
    """Axes that are parallel, or nearly so: then beta is the tilt across the line between them (Hayati)."""
    # along parallel axes any share of the distance is right: the row that this leads to has it, as tables have it
    along = float(p[2] / rotation[2, 2])
    foot = p - along * rotation[:, 2]
    turn = _folded(math.atan2(foot[1], foot[0])) if math.hypot(foot[0], foot[1]) > SAME_DIRECTION else 0.0
    seen = rotation_about(Z_AXIS, -turn) @ rotation
    a = float(foot[0] * math.cos(turn) + foot[1] * math.sin(turn))
    alpha = math.atan2(-seen[1, 2], seen[2, 2])
    beta = math.asin(float(np.clip(seen[0, 2], -1.0, 1.0))) if nearly else 0.0
    turned = rotation_about(Y_AXIS, -beta) @ rotation_about(X_AXIS, -alpha) @ seen
    return Passage(turn, 0.0, a, alpha, math.atan2(turned[1, 0], turned[0, 0]), along, beta)


def _folded(turn: float) -> float:
    """A common normal has two senses: the one nearer to x, so that a may be negative and tables stay as they were."""
    if turn > 0.5 * math.pi + 1e-9:
        return turn - math.pi
    return turn + math.pi if turn < -0.5 * math.pi - 1e-9 else turn


def _last_turn(rotation: Array, turn: float, alpha: float) -> float:
    left = rotation_about(X_AXIS, -alpha) @ rotation_about(Z_AXIS, -turn) @ rotation
    return math.atan2(left[1, 0], left[0, 0])


Assembled = tuple[tuple[Row, ...], Array, Array]
"""Rows, the base before them (4, 4) and what comes after them (4, 4)."""


def _standard(joints: tuple[AlignedJoint, ...], passages: list[Passage]) -> Assembled:
    """Row i is Rz(theta) Tz(d) Tx(a) Rx(alpha): its joint, then the common normal to the next axis."""
    here = [NO_PASSAGE, *passages[1:-1]]
    rows = [_row(*each) for each in zip((j.row for j in joints), here, passages[1:], passages[1:], strict=True)]
    last = passages[-1]
    # the row before the flange holds what of the flange a row can hold; Ry(beta), if any, is no loss there
    rest = _about_y(last.beta) @ _about_z(last.next_turn, last.next_slide)
    return tuple(rows), joints[0].before, rest


def _modified(joints: tuple[AlignedJoint, ...], passages: list[Passage]) -> Assembled:
    """Row i is Rx(alpha) Tx(a) Rz(theta) Tz(d): the common normal from the axis before, then its joint."""
    first, last = passages[0], passages[-1]
    base = np.eye(4)
    if first.beta or max(abs(first.turn), abs(first.slide)) > NOTHING:
        # the first row cannot hold it alone; the base, which takes anything, then takes all
        base, passages = joints[0].before, [NO_PASSAGE, *passages[1:]]
    rows = [_row(*each) for each in zip((j.row for j in joints), passages, passages, passages[1:], strict=False)]
    normal = homogeneous(rotation_about(X_AXIS, last.alpha), (last.a, 0.0, 0.0))
    return tuple(rows), base, normal @ _about_y(last.beta) @ _about_z(last.next_turn, last.next_slide)


def _row(row: Row, arriving: Passage, normal: Passage, leaving: Passage) -> Row:
    geometry = {
        "theta": _wrapped(arriving.next_turn + leaving.turn),
        "d": arriving.next_slide + leaving.slide,
        "a": normal.a,
        "alpha": _wrapped(normal.alpha),
    }
    return Row(row.name, row.joint, geometry, limits=row.limits)


def _about_z(angle: float, distance: float) -> Array:
    return homogeneous(rotation_about(Z_AXIS, angle), (0.0, 0.0, distance))


def _about_y(angle: float) -> Array:
    return homogeneous(rotation_about(Y_AXIS, angle))


def _wrapped(angle: float) -> float:
    """The angle within half a turn; half a turn itself is positive."""
    found = math.remainder(angle, 2.0 * math.pi)
    return -found if found == -math.pi else found


def _fitted(table: Robot, rigid_poses: Measurements) -> Robot:
    """The table nearest to the rigid robot: all its parameters, its base and its tool fitted to its poses."""
    opened = table.with_frames({name: replace(table.frames[name], known=False) for name in ("base", "tool")})
    return calibrate(opened, rigid_poses, fix=("*.beta", "*.b")).robot
