"""Pose accuracy and pose repeatability of ISO 9283, from poses that were measured more than once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.measurements import Measurements, repeats

FEWEST = 3
"""Repeats of a pose from which on its repeatability is told; the standard measures 30."""


@dataclass(frozen=True)
class Repeatability:
    """After ISO 9283:1998, 7.2, with the pose that the robot model predicts as the command; m, or rad.

    With the errors e_j of a pose's repeats and their barycentre ē: the accuracy is AP = |ē|, the repeatability
    RP = mean(l) + 3 S_l of the distances l_j = |e_j - ē| from it, S_l their standard deviation with n - 1.

    Attributes:
        poses: how many were measured more than once.
        repeats: rows of these poses, the fewest and the most of one.
        accuracy: mean AP over the poses, and the largest.
        judged: poses measured at least FEWEST times, which the repeatability is told of.
        repeatability: mean RP over these, and the largest; None where there are none.
    """

    poses: int
    repeats: tuple[int, int]
    accuracy: tuple[float, float]
    judged: int
    repeatability: tuple[float, float] | None


def repeatability(data: Measurements, errors: Array) -> Repeatability | None:
    """Accuracy and repeatability of the poses in data that were measured more than once.

    Repeats are rows of one pose with the same target, payload and station. Errors stand in for attained positions, so
    that joint positions that were read back a little different each time do not count as scatter of the robot.

    Args:
        data: the rows.
        errors: (n, 3) measured - predicted position [m] or rotation vector [rad], NaN where nothing was measured.

    Returns:
        None where no pose was measured twice.
    """
    rows = np.flatnonzero(np.isfinite(errors).all(axis=1))
    group = _groups(data)[rows]
    names, group, counts = np.unique(group, return_inverse=True, return_counts=True)
    if not (counts > 1).any():
        return None
    errors = errors[rows]
    centre = np.stack([np.bincount(group, axis, len(names)) for axis in errors.T], axis=1) / counts[:, None]
    distance = np.linalg.norm(errors - centre[group], axis=1)
    mean = np.bincount(group, distance, len(names)) / counts
    square = np.bincount(group, (distance - mean[group]) ** 2, len(names)) / np.maximum(counts - 1, 1)
    accuracy, spread = np.linalg.norm(centre, axis=1), mean + 3.0 * np.sqrt(square)
    several, judged = counts > 1, counts >= FEWEST
    return Repeatability(
        poses=int(several.sum()),
        repeats=(int(counts[several].min()), int(counts[several].max())),
        accuracy=(float(accuracy[several].mean()), float(accuracy[several].max())),
        judged=int(judged.sum()),
        repeatability=(float(spread[judged].mean()), float(spread[judged].max())) if judged.any() else None,
    )


def _groups(data: Measurements) -> NDArray[np.intp]:
    """A number for each row, the same for repeats."""
    group = repeats(data)
    for labels in (data.target, data.load, data.station):
        if labels is not None:
            group = group * (len(labels.names) + 1) + labels.codes + 1
    return group
