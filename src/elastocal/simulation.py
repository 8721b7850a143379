"""Simulation: measurements of a robot that does not exist."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.measurements import KINDS, Labels, Measurements
from elastocal.prediction import predict
from elastocal.robot import Robot


def random_poses(robot: Robot, count: int, seed: int | np.random.Generator = 0) -> Array:
    """Joint positions (count, joints), uniform within the joints' limits; +-180 deg or +-0.5 m where there are none."""
    rng = np.random.default_rng(seed)
    free = {"revolute": (-np.pi, np.pi), "prismatic": (-0.5, 0.5)}
    ranges = [row.limits or free[row.joint] for row in robot.joints if row.joint]
    if robot.positions != len(ranges):  # coupled: no joint of the controller is one of the model's
        ranges = [free["revolute"]] * robot.positions
    low, high = np.array(ranges).T
    return rng.uniform(low, high, size=(count, len(low)))


def simulate(
    robot: Robot,
    q: Array,
    *,
    kinds: Sequence[str] = ("position",),
    noise: float = 0.0,
    noise_angle: float = 0.0,
    state_sigma: bool = False,
    station: str | None = None,
    target: str | None = None,
    load: str | None = None,
    wrench: Array | None = None,
    seed: int | np.random.Generator = 0,
) -> Measurements:
    """Measure an actual robot at joint positions q (poses, joints).

    Args:
        robot: the actual robot.
        q: the controller's joint positions [rad or m].
        kinds: what is measured, of "position", "orientation", "distance".
        noise: standard deviation of each coordinate of the position, and of the distance [m].
        noise_angle: standard deviation of the orientation about each axis [rad].
        state_sigma: whether the measurements state these standard deviations.
        station: name in the robot; None: its base.
        target: name in the robot; None: the tool's origin.
        load: name of a payload in the robot.
        wrench: (poses, 6) on the tool.
        seed: of the noise.

    Raises:
        InputError: a kind of observation that does not exist.
    """
    faults = [unknown_name("kind", kind, KINDS) for kind in kinds if kind not in KINDS]
    if faults:
        raise InputError(*faults)
    rng = np.random.default_rng(seed)
    n = len(q)
    position, rotation = predict(robot, q, station=station, target=target, load=load, wrench=wrench)
    turns = Rotation.from_rotvec(noise_angle * rng.standard_normal((n, 3))).as_matrix()
    shifts = noise * rng.standard_normal((n, 4))
    return Measurements(
        q=np.asarray(q, dtype=float),
        position=position + shifts[:, :3] if "position" in kinds else None,
        orientation=turns @ rotation if "orientation" in kinds else None,
        distance=np.linalg.norm(position, axis=1) + shifts[:, 3] if "distance" in kinds else None,
        sigma=np.full((n, 3), noise) if state_sigma and noise else None,
        sigma_angle=np.full(n, noise_angle) if state_sigma and noise_angle else None,
        target=None if target is None else Labels.of([target] * n),
        load=None if load is None else Labels.of([load] * n),
        station=None if station is None else Labels.of([station] * n),
        wrench=wrench,
    )
