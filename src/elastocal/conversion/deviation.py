"""How far apart two robots are: what is left of a robot where another program has less of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastocal.chain import Array, rotation_vectors
from elastocal.identification import choose_gauge, fit_frames
from elastocal.measurements import Labels, Measurements
from elastocal.parameters import FRAME_GROUPS, parameters_of
from elastocal.prediction import predict
from elastocal.robot import Frame, Robot

AT_BASE = Frame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), known=True)


@dataclass(frozen=True)
class Residual:
    """What a reading of a robot leaves of its tool's pose, over poses, without one payload or with it.

    Attributes:
        reading: what of the robot the reader has.
        load: the payload; None without one.
        refitted: whether base and tool were fitted to the robot first, as by teaching both anew on it.
        position: (poses,) distance of the tool's origins [m].
        angle: (poses,) between the tool's orientations [rad].
    """

    reading: str
    load: str | None
    refitted: bool
    position: Array
    angle: Array


def rigid(robot: Robot) -> Robot:
    """The robot's geometry alone: no compliance, joint maps, masses, targets, stations."""
    bare = tuple(replace(row, mass=0.0, com=(0.0, 0.0, 0.0)) for row in robot.rows)
    return Robot(robot.name, robot.convention, bare, base=robot.base, tool=robot.tool, coupling=robot.coupling)


def at_its_base(robot: Robot) -> Robot:
    """The robot seen from its own base."""
    return replace(robot, base=AT_BASE, stations={})


def residuals_left(robot: Robot, readings: Mapping[str, Robot], q: Array, q_fit: Array) -> tuple[Residual, ...]:
    """What each reading leaves of the loaded robot's tool pose, in its base frame.

    Without a payload and with each one; as read, and with base and tool fitted at other poses.

    Args:
        robot: with all that is known of it.
        readings: robots that a reader has, by what they are; their base is from the robot's base to their first frame.
            A payload that they know is on them too.
        q: (poses, joints) joint positions [rad or m] at which they are compared.
        q_fit: (poses, joints) at which base and tool are fitted.

    Raises:
        EquilibriumError: the robot does not settle under its load.
    """
    whole = at_its_base(robot)
    found = []
    for load in (None, *robot.loads):
        wanted, to_fit = predict(whole, q, load=load), predict(whole, q_fit, load=load)
        for name, reading in readings.items():
            found.append(_residual(name, load, False, reading, q, wanted))
            carried = Labels.same(load if load in reading.loads else None, len(q_fit))
            fitted = _refitted(reading, Measurements(q_fit, *to_fit, load=carried))
            found.append(_residual(name, load, True, fitted, q, wanted))
    return tuple(found)


def _residual(
    name: str, load: str | None, refitted: bool, reading: Robot, q: Array, wanted: tuple[Array, Array]
) -> Residual:
    position, rotation = predict(reading, q, load=load if load in reading.loads else None)
    turn = rotation_vectors((wanted[1] @ rotation.transpose(0, 2, 1)).transpose(1, 2, 0))
    return Residual(name, load, refitted, np.linalg.norm(wanted[0] - position, axis=1), np.linalg.norm(turn, axis=0))


def _refitted(reading: Robot, data: Measurements) -> Robot:
    opened = reading.with_frames({n: replace(reading.frames[n], known=False) for n in ("base", "tool")})
    names = [n for n, p in parameters_of(opened).items() if p.open and p.group in FRAME_GROUPS]
    return fit_frames(opened, data, choose_gauge(opened, data, names))
