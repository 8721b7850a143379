"""Where searches start: poses all over the workspace, the same for every run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.compensation.machine import Machine, joint_limits, slides
from elastocal.compensation.targets import Goals
from elastocal.robot import Robot

POSES = 4000

STRIDE = 0.5
"""Half the range of a sliding joint without limits [m]."""

PREFERENCE = 1.0
"""What a start half a turn from the preferred one in every joint is charged, in squares of the workspace's size."""

CHUNK = 500
"""Goals that are compared with the pool at once: the table of distances stays in cache."""


@dataclass(frozen=True)
class Pool:
    """Poses of a robot and where they put its TCPs.

    Attributes:
        q: (joints, poses).
        features: for each driver of the machine (poses, 12): position and rotation, so that squared distances of
            features are squared distances of poses in metres.
        size: root mean square distance of the positions from their middle [m].
        joints: (poses,) squared distance from the preferred pose, in the same measure.
        preferred: (joints,) that pose.
    """

    q: Array
    features: tuple[Array, ...]
    size: float
    joints: Array
    preferred: Array

    @property
    def weight(self) -> float:
        """Metres that count as much as a radian."""
        return 0.5 * self.size

    def nearest(self, machine: Machine, goals: Goals, rows: NDArray[np.intp]) -> Array:
        """The pose near each goal of rows (k,), (joints, k); poses near the preferred one come before others."""
        return self._nearest(machine, goals, rows, 1, self.joints)[:, 0]

    def various(self, machine: Machine, goals: Goals, rows: NDArray[np.intp], count: int) -> Array:
        """Poses near the goals of rows (k,), each the nearest in another part of the pool, (joints, count, k)."""
        return self._nearest(machine, goals, rows, count, None)

    def _nearest(
        self, machine: Machine, goals: Goals, rows: NDArray[np.intp], parts: int, handicap: Array | None
    ) -> Array:
        chosen = np.empty((parts, len(rows)), dtype=int)
        for number, features in enumerate(self.features):
            of = np.flatnonzero(machine.group[rows] == number)
            for some in np.split(of, range(CHUNK, len(of), CHUNK)):
                wanted = _features(goals.take(rows[some]), self.weight)
                squares = -2.0 * wanted @ features.T + self._squares(features, goals.oriented[rows[some]])
                if handicap is not None:
                    squares += handicap
                for part in range(parts):
                    chosen[part, some] = part + parts * squares[:, part::parts].argmin(axis=1)
        return self.q[:, chosen]

    def _squares(self, features: Array, oriented: NDArray[np.bool_]) -> Array:
        """Squared lengths of the features, (k, poses) or (poses,); of positions alone where that is what is asked."""
        full, alone = (features**2).sum(axis=1), (features[:, :3] ** 2).sum(axis=1)
        if oriented.all():
            return full
        return np.where(oriented[:, None], full, alone)


def _features(goals: Goals, weight: float) -> Array:
    """(k, 12) features of goals; zero in place of an orientation that does not matter."""
    turned = weight / np.sqrt(2.0) * (goals.rotation * goals.oriented).reshape(9, -1)
    return np.concatenate([goals.position, turned]).T


def pool_of(robot: Robot, machine: Machine, preferred: Array | None = None) -> Pool:
    """A pool for the rows of a machine, which is the rigid robot; `preferred` joint positions (joints,)."""
    low, high = starting_range(robot)
    middle = 0.5 * (low + high) if preferred is None else preferred
    rng = np.random.default_rng(0)
    q = np.column_stack([rng.uniform(low, high, (POSES, len(low))).T, middle])
    poses = [driver.at(q, derivatives=False) for driver in machine.drivers]
    positions = poses[0].position
    size = max(float(np.sqrt(((positions - positions.mean(axis=1, keepdims=True)) ** 2).sum(axis=0).mean())), 1e-3)
    every = np.ones(q.shape[1], dtype=bool)
    features = tuple(_features(Goals(pose.position, pose.rotation, every, every), 0.5 * size) for pose in poses)
    scale = np.where(slides(robot), STRIDE, np.pi)[:, None]
    away = (((q - middle[:, None]) / scale) ** 2).mean(axis=0)
    return Pool(q, features, size, PREFERENCE * size**2 * away, middle)


def starting_range(robot: Robot) -> tuple[Array, Array]:
    """Lowest and highest joint positions (joints,) of starts: within the limits, and within a turn about zero."""
    low, high = joint_limits(robot)
    reach = np.where(slides(robot), STRIDE, np.pi)
    near_low = np.where(np.isfinite(low) & (slides(robot) | (low > -reach) | (high < reach)), low, -reach)
    near_high = np.where(np.isfinite(high) & (slides(robot) | (low > -reach) | (high < reach)), high, reach)
    return near_low, near_high
