"""Residuals of data, and what they come to."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.measurements import Measurements
from elastocal.prediction import Model, Part
from elastocal.robot import Robot


@dataclass(frozen=True)
class Residuals:
    """Measured - predicted, row by row, in the instrument's frame; NaN where nothing was measured.

    Attributes:
        n: number of rows.
        position: (n, 3) [m], or None where no row has a position.
        orientation: (n, 3) rotation vectors [rad], or None.
        distance: (n,) [m], or None.
    """

    n: int
    position: Array | None
    orientation: Array | None
    distance: Array | None

    @property
    def norms(self) -> Array:
        """(n,) length of the position residual, of the distance's where there is no position [m]."""
        norms = np.full(self.n, np.nan) if self.position is None else np.linalg.norm(self.position, axis=1)
        return norms if self.distance is None else np.where(np.isfinite(norms), norms, np.abs(self.distance))

    @property
    def angles(self) -> Array | None:
        """(n,) angle of the orientation residual [rad], or None."""
        return None if self.orientation is None else np.linalg.norm(self.orientation, axis=1)


@dataclass(frozen=True)
class Statistics:
    """Of distances [m] or angles [rad] over n rows; `angle` beside a position's where orientations were measured."""

    n: int
    mean: float
    max: float
    rms: float
    std: float
    angle: Statistics | None = None


def residuals(robot: Robot, data: Measurements) -> Residuals:
    """Predict data with a robot whose frames are all in place."""
    return residuals_of(len(data), Model(robot, (), data).parts(np.zeros(0), derivatives=False))


def residuals_of(n: int, parts: Iterable[Part]) -> Residuals:
    """The residuals of n rows, of which parts have some each."""
    found: dict[str, Array] = {}
    for part in parts:
        if part.kind not in found:
            found[part.kind] = np.full((n, len(part.residual)), np.nan)
        found[part.kind][part.rows] = part.residual.T
    distance = found.get("distance")
    return Residuals(n, found.get("position"), found.get("orientation"), None if distance is None else distance[:, 0])


def statistics(residuals: Residuals, rows: NDArray[np.bool_] | None = None) -> Statistics:
    """Mean, largest, root mean square and standard deviation of the rows' distances, and of their angles."""
    chosen = np.ones(residuals.n, dtype=bool) if rows is None else rows
    angle = None if residuals.angles is None else statistics_of(residuals.angles[chosen])
    return statistics_of(residuals.norms[chosen], angle if angle and angle.n else None)


def statistics_of(values: Array, angle: Statistics | None = None) -> Statistics:
    """Statistics of distances or angles (n,), NaN left out."""
    values = values[np.isfinite(values)]
    if not len(values):
        return Statistics(0, 0.0, 0.0, 0.0, 0.0, angle)
    rms = float(np.sqrt((values**2).mean()))
    return Statistics(len(values), float(values.mean()), float(values.max()), rms, float(values.std()), angle)
