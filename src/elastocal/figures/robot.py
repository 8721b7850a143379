"""The robot drawn as a skeleton: along its elements, from the base to the measured target."""

from __future__ import annotations

import numpy as np

from elastocal.chain import Array, Chain, forward, place, points
from elastocal.figures.panel import Trace, numbers
from elastocal.figures.rows import Rows, errors_of
from elastocal.figures.style import JOINT, LINK
from elastocal.identification import AnyResult
from elastocal.robot import Robot, assemble

SAME = 1e-6
"""Points nearer than this [m] are one."""


def skeleton(robot: Robot, q: Array, station: str | None = None, target: str | None = None) -> tuple[Array, Array]:
    """The robot as a path in its base's frame, undeflected.

    Args:
        robot: with all frames in place.
        q: (joints,) the controller's joint positions [rad or m].
        station: the instrument's station; None: the base.
        target: where the path ends; None: the tool's origin.

    Returns:
        The path (points, 3), and where the joints are on it (joints, 3) [m].
    """
    assembly = assemble(robot, station, target)
    chain = assembly.mechanism.chain
    every = Chain(chain.elements, chain.moving, tuple(range(1, len(chain.elements) + 1)))
    placement = place(every, every.values)
    frames = forward(placement, assembly.motion(np.asarray(q, dtype=float)[:, None]))
    path = np.array(
        [
            points(frames, int(frame), origin)[:, 0]
            for frame, origin in zip(every.mark_frames, placement.mark_origins, strict=True)
        ]
    )
    base = robot.base if station is None else robot.stations[station]
    path = (path - base.translation) @ base.rotation
    first = chain.marks[0] - 1  # the base's last element: the path starts at the robot's foot
    joints = path[[chain.index[row.joint_element] for row in robot.joints if row.joint_element]]
    path = path[first:]
    apart = np.append(True, np.linalg.norm(np.diff(path, axis=0), axis=1) > SAME)
    return path[apart], joints


def arm_traces(result: AnyResult, rows: Rows, row: int) -> list[Trace]:
    """The robot at a row of the data, as lines and joints."""
    data = errors_of(result).data
    at = int(rows.index[row])
    station, target = (
        None if label is None else label.name(int(label.codes[at])) for label in (data.station, data.target)
    )
    path, joints = skeleton(result.robot, data.q[at], station, target)
    links: Trace = {"type": "scatter3d", "mode": "lines", "name": "robot", "line": {"color": LINK, "width": 9}}
    knots: Trace = {"type": "scatter3d", "mode": "markers", "name": "joints", "marker": {"size": 5, "color": JOINT}}
    return [trace | _placed(at) | {"hoverinfo": "skip"} for trace, at in ((links, path), (knots, joints))]


def _placed(at: Array) -> Trace:
    return {axis: numbers(values) for axis, values in zip("xyz", at.T, strict=True)}
