"""Actual robots: what might have been built after a nominal one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.prediction import predict
from elastocal.robot import Frame, Robot
from elastocal.simulation.poses import random_poses

AWAY = 2.0
"""A drawn instrument stands so many times the robot's reach away,"""

OFFSET = 0.1
"""and a drawn tool reaches this fraction of it beyond the flange, and as far to the side."""


def with_geometry_errors(robot: Robot, length: float, angle: float, seed: int | np.random.Generator = 0) -> Robot:
    """The robot with normal random errors on every length and angle of its rows.

    Args:
        robot: the nominal one.
        length: standard deviation of the errors of lengths [m].
        angle: standard deviation of the errors of angles, joint offsets among them [rad].
        seed: of the errors.
    """
    rng = np.random.default_rng(seed)
    errors = {
        element.name: (angle if element.rotation else length) * rng.standard_normal()
        for elements in robot.row_elements
        for element in elements
        if element.name
    }
    return robot.displaced(errors)


def reach_of(robot: Robot) -> float:
    """How far a robot's flange gets from its base [m]."""
    bare = robot.with_frames(dict.fromkeys(robot.frames, Frame(known=True)))
    return max(float(np.linalg.norm(predict(bare, random_poses(bare, 500))[0], axis=1).max()), OFFSET)


def with_frames_drawn(robot: Robot, seed: int | np.random.Generator = 0, reach: float | None = None) -> Robot:
    """The robot with a frame drawn for each that is neither known nor guessed: so it might have been set up.

    An instrument stands somewhere around the robot, upright to about a degree. A tool puts its target off the last
    axis, without which the last joints could not be told.

    Args:
        robot: whose frames are drawn.
        seed: of the frames.
        reach: of the robot [m]; None: it is looked for.
    """
    rng = np.random.default_rng(seed)
    reach = reach_of(robot) if reach is None else reach
    drawn = {}
    for name, frame in robot.frames.items():
        if not frame.known and frame.xyz is None and frame.rpy is None:
            drawn[name] = _stand(reach, rng) if name.startswith(("base", "station.")) else _tip(reach, rng)
    return robot.with_frames(drawn)


def _stand(reach: float, rng: np.random.Generator) -> Frame:
    """Of a robot's base, seen by an instrument that stands around it: instrument_T_base."""
    around, turned = rng.uniform(-np.pi, np.pi, 2).tolist()
    tilt_x, tilt_y = (0.02 * rng.standard_normal(2)).tolist()
    height = reach * float(rng.uniform(-0.5, 0.0))
    away = AWAY * reach
    return Frame((away * float(np.cos(around)), away * float(np.sin(around)), height), (tilt_x, tilt_y, turned))


def _tip(reach: float, rng: np.random.Generator) -> Frame:
    """Of a tool, or of a target on it."""
    around, turned = rng.uniform(-np.pi, np.pi, 2).tolist()
    side = OFFSET * reach
    return Frame((side * float(np.cos(around)), side * float(np.sin(around)), side), (0.0, 0.0, turned))


def as_built(robot: Robot) -> Robot:
    """The robot with all its frames known: a first guess is where the frame is, and without one it is the identity."""
    return robot.with_frames({name: _settled(frame) for name, frame in robot.frames.items()})


def _settled(frame: Frame) -> Frame:
    origin = (0.0, 0.0, 0.0)
    return replace(frame, xyz=frame.xyz or origin, rpy=frame.rpy or origin, known=True)
