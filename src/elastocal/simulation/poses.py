"""Poses at random: within the joints' limits, and where an instrument sees the target."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.prediction import predict
from elastocal.robot import Robot
from elastocal.simulation.region import Region

MOST_TRIES = 100_000
"""So many poses are tried, and TRIES_PER_POSE for each that is wanted, before none is said to be found."""

TRIES_PER_POSE = 200

CENTRE_POSES = 2000
"""The working centre is the mean over so many."""


def random_poses(
    robot: Robot,
    count: int,
    seed: int | np.random.Generator = 0,
    *,
    region: Region | None = None,
    actual: Robot | None = None,
    station: str | None = None,
    target: str | None = None,
    load: str | None = None,
) -> Array:
    """Joint positions (count, joints), uniform within the joints' limits; +-180 deg or +-0.5 m where there are none.

    Args:
        robot: whose limits they keep to.
        count: how many.
        seed: of the poses.
        region: where the target must be; None: anywhere.
        actual: the robot whose target that is; None: `robot`.
        station: the instrument's station; None: the robot's base.
        target: a target of the robot; None: the tool's origin.
        load: a payload of the robot.

    Raises:
        InputError: too few poses put the target into the region; says what rejected how many.
    """
    rng = np.random.default_rng(seed)
    if region is None:
        return _uniform(robot, count, rng)
    moved = actual or robot

    def positions(q: Array) -> Array:
        return predict(moved, q, station=station, target=target, load=load)[0]

    # a generator of its own, so that the centre is the same for every seed and takes no numbers from the poses
    centre = None
    if region.cone is not None:
        centre = positions(_uniform(robot, CENTRE_POSES, np.random.default_rng(0))).mean(axis=0)
    base = moved.base if station is None else moved.stations[station]
    drawn = draw(
        robot, count, rng, lambda q: region.rejected(positions(q), base, centre), MOST_TRIES + TRIES_PER_POSE * count
    )
    if len(drawn.q) < count:
        raise InputError(drawn.too_few(count))
    return drawn.q


class Drawn(NamedTuple):
    """Poses drawn at random that nothing rejects.

    Attributes:
        q: (poses, joints).
        tried: how many were drawn.
        rejected: how many of them each constraint rejects.
    """

    q: Array
    tried: int
    rejected: Counter[str]

    def too_few(self, count: int) -> str:
        """A sentence on there being less than `count`."""
        shares = (f"{name} rejects {100.0 * n / self.tried:.4g} %" for name, n in self.rejected.most_common())
        return (
            f"found {len(self.q)} of {count} poses: of {self.tried} drawn within the joint limits, "
            f"{', '.join(shares)}; widen what rejects most"
        )


def draw(
    robot: Robot,
    count: int,
    rng: np.random.Generator,
    rejected: Callable[[Array], Mapping[str, NDArray[np.bool_]]],
    most: int,
) -> Drawn:
    """Poses within the joints' limits that nothing rejects: `count` of them, fewer if `most` tries do not find them.

    Args:
        robot: whose limits they keep to.
        count: how many.
        rng: draws them.
        rejected: which of some poses (n, joints) each constraint rejects, (n,) by name.
        most: after so many tries no more are drawn.
    """
    chosen, tried, counts = np.empty((0, robot.positions)), 0, Counter[str]()
    while len(chosen) < count and tried < most:
        q = _uniform(robot, max(count, tried // 4), rng)
        misses = rejected(q)
        counts.update({name: int(miss.sum()) for name, miss in misses.items()})
        missed = np.logical_or.reduce([np.zeros(len(q), dtype=bool), *misses.values()])
        chosen, tried = np.concatenate([chosen, q[~missed]]), tried + len(q)
    return Drawn(chosen[:count], tried, counts)


def _uniform(robot: Robot, count: int, rng: np.random.Generator) -> Array:
    free = {"revolute": (-np.pi, np.pi), "prismatic": (-0.5, 0.5)}
    ranges = [row.limits or free[row.joint] for row in robot.joints if row.joint]
    if robot.positions != len(ranges):  # coupled: no joint of the controller is one of the model's
        ranges = [free["revolute"]] * robot.positions
    low, high = np.array(ranges).T
    return rng.uniform(low, high, size=(count, len(low)))
